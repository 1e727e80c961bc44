#include "core/render/model/glass_segments.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"

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

}  // namespace vitrine
