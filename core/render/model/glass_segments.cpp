#include "core/render/model/glass_segments.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr size_t kRows = 8;
constexpr float kPastFront = 1e-5f;  // relative step beyond a hit

struct Segment {
  SegmentKind kind = SegmentKind::NoMesh;
  float front = 0, back = 0;
  uint32_t region = 0;
};

Segment segment(const Vec3f& eye, const Vec3f& direction, float surface, const GlassMesh& mesh, const GlassSegmentsDesc& desc) {
  Segment s{.front = surface};
  const float tolerance = std::max(desc.tolerance_voxels * mesh.voxel, desc.tolerance_rel * surface);
  const auto first = mesh.all.first_hit(eye, direction);
  if (!first) return s;
  if (first->from_inside || std::abs(first->t - surface) > tolerance) return s.kind = SegmentKind::Apart, s;
  const auto pane = mesh.panes.first_hit(eye, direction);
  if (!pane || pane->t > first->t * (1 + kPastFront)) return s.kind = SegmentKind::NotGlass, s;
  s.kind = SegmentKind::Open;
  s.front = pane->t;
  s.region = mesh.region[pane->face];
  const auto back = mesh.panes.back_surface(eye, direction, pane->t * (1 + kPastFront));
  if (!back || back->t < pane->t + desc.thinnest_voxels * mesh.voxel) return s;
  s.kind = SegmentKind::Closed;
  s.back = back->t;
  return s;
}

}  // namespace

size_t GlassSegments::glass() const {
  size_t sum = 0;
  for (size_t k = 1; k < kSegmentKinds; ++k) sum += count[k];
  return sum;
}

double GlassSegments::agreement() const {
  const size_t all = glass() - count[static_cast<size_t>(SegmentKind::NotGlass)];
  const size_t agree = count[static_cast<size_t>(SegmentKind::Open)] + count[static_cast<size_t>(SegmentKind::Closed)];
  return all > 0 ? double(agree) / double(all) : 1;
}

GlassSegments glass_segments(const View& view, std::span<const float> zdepth, std::span<const float> glass, const GlassMesh& mesh,
                             const GlassSegmentsDesc& desc) {
  const Intrinsics& k = view.intrinsics;
  const size_t width = static_cast<size_t>(k.width), height = static_cast<size_t>(k.height);
  GlassSegments out;
  out.kind.assign(width * height, SegmentKind::None);
  out.front.assign(width * height, 0.f);
  out.back.assign(width * height, 0.f);
  out.region.assign(width * height, 0);
  const Vec3f eye = cast<float>(view.centre_in_world());
  std::vector<std::array<size_t, kSegmentKinds>> counts(chunk_count(height, kRows));
  parallel_chunks(height, kRows, [&](size_t chunk, size_t top, size_t bottom) {
    for (size_t y = top; y < bottom; ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t i = y * width + x;
        if (!(glass[i] > 0.5f)) continue;
        Segment s;
        if (zdepth[i] > 0) {
          const Vec3d ray = k.ray(double(x) + 0.5, double(y) + 0.5);
          const double per_z = length(ray);
          const Vec3f direction = cast<float>(transposed_times(view.cam_from_world.rotation, ray / per_z));
          s = segment(eye, direction, float(per_z * double(zdepth[i])), mesh, desc);
        }
        out.kind[i] = s.kind;
        out.front[i] = s.front;
        out.back[i] = s.back;
        out.region[i] = s.region;
        ++counts[chunk][static_cast<size_t>(s.kind)];
      }
  });
  for (const auto& c : counts)
    for (size_t i = 0; i < kSegmentKinds; ++i) out.count[i] += c[i];
  const size_t split = out.count[static_cast<size_t>(SegmentKind::Open)] + out.count[static_cast<size_t>(SegmentKind::Closed)];
  out.trusted = split > 0 && out.agreement() >= double(desc.min_agreement);
  return out;
}

namespace {

constexpr float kCellVoxels = 4, kSigmaVoxels = 2;
constexpr float kClearTriangle = 0.5f;
constexpr size_t kGlassGrain = 1024;

// Uniform grid of surfels: sorted cell keys, neighbours by binary search.
class SurfelGrid {
 public:
  SurfelGrid(const SplatLayer& layer, float cell) : layer_(layer), cell_(cell) {
    entries_.resize(layer.size());
    for (size_t i = 0; i < layer.size(); ++i) entries_[i] = {key(cell_of(position(i))), static_cast<uint32_t>(i)};
    std::ranges::sort(entries_);
  }
  Vec3f position(size_t i) const {
    const float* p = layer_.at(Attribute::Mean, i);
    return {p[0], p[1], p[2]};
  }
  template <class Body>
  void around(const Vec3f& p, Body&& body) const {
    const std::array<int64_t, 3> c = cell_of(p);
    for (int64_t z = c[2] - 1; z <= c[2] + 1; ++z)
      for (int64_t y = c[1] - 1; y <= c[1] + 1; ++y)
        for (int64_t x = c[0] - 1; x <= c[0] + 1; ++x) {
          const uint64_t k = key({x, y, z});
          for (auto it = std::ranges::lower_bound(entries_, std::pair{k, 0u}); it != entries_.end() && it->first == k; ++it)
            body(it->second);
        }
  }

 private:
  std::array<int64_t, 3> cell_of(const Vec3f& p) const {
    std::array<int64_t, 3> c;
    for (size_t a = 0; a < 3; ++a) c[a] = static_cast<int64_t>(std::floor(double(p[a]) / double(cell_)));
    return c;
  }
  // Hash collisions are harmless: colliding cells are too far away to count.
  static uint64_t key(const std::array<int64_t, 3>& c) {
    return mix64(mix64(static_cast<uint64_t>(c[0]), static_cast<uint64_t>(c[1])), static_cast<uint64_t>(c[2]));
  }
  const SplatLayer& layer_;
  float cell_;
  std::vector<std::pair<uint64_t, uint32_t>> entries_;
};

}  // namespace

std::vector<uint8_t> glass_faces(const TriMesh& mesh, const SplatLayer& diffuse, float voxel) {
  const SurfelGrid grid(diffuse, kCellVoxels * voxel);
  std::vector<uint8_t> glass(mesh.faces.size(), 0);
  parallel_chunks(glass.size(), kGlassGrain, [&](size_t, size_t first, size_t last) {
    for (size_t f = first; f < last; ++f) {
      const auto& v = mesh.faces[f];
      const Vec3f centre = (1.f / 3.f) * (mesh.positions[v[0]] + mesh.positions[v[1]] + mesh.positions[v[2]]);
      float sum = 0, clear = 0;
      grid.around(centre, [&](uint32_t i) {
        const float d = length(grid.position(i) - centre) / (kSigmaVoxels * voxel);
        const float w = sigmoid(*diffuse.at(Attribute::Opacity, i)) * std::exp(-0.5f * d * d);
        sum += w;
        clear += w * sigmoid(*diffuse.at(Attribute::Transmission, i));
      });
      glass[f] = clear > kClearTriangle * sum;
    }
  });
  return glass;
}

GlassMesh::GlassMesh(const TriMesh& mesh, const SplatLayer& diffuse, float voxel)
    : GlassMesh(mesh, submesh(mesh, glass_faces(mesh, diffuse, voxel)), voxel) {}

GlassMesh::GlassMesh(const TriMesh& mesh, TriMesh glass_part, float voxel)
    : glass(std::move(glass_part)), voxel(voxel), all(mesh), panes(glass) {
  const FaceComponents parts = face_components(glass);
  regions = parts.faces.size();
  std::vector<uint32_t> by_size(regions), rank(regions);
  std::iota(by_size.begin(), by_size.end(), 0u);
  std::ranges::stable_sort(by_size, std::ranges::greater{}, [&](uint32_t part) { return parts.faces[part]; });
  for (uint32_t i = 0; i < by_size.size(); ++i) rank[by_size[i]] = i;
  region.resize(parts.label.size());
  for (size_t f = 0; f < region.size(); ++f) region[f] = rank[parts.label[f]];
}

}  // namespace vitrine
