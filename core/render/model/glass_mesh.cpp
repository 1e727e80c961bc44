#include "core/render/model/glass_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

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
