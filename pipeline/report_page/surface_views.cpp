#include "pipeline/report_page/surface_views.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr int kSubpixels = 2;  // rays per pixel and axis
constexpr Vec3f kBackground{0.88f, 0.88f, 0.87f};
constexpr Vec3f kClay{0.80f, 0.77f, 0.72f};
constexpr float kAmbient = 0.18f, kHeadlight = 0.62f, kFromAbove = 0.2f;

struct Shades {
  Vec3f clay = kBackground, normal = kBackground;
};

Shades shades_of(const MeshHits& mesh, const View& view, const Vec3f& origin, double px, double py) {
  const Vec3f direction = cast<float>(normalized(transposed(view.cam_from_world.rotation) * view.intrinsics.ray(px, py)));
  const auto hit = mesh.first_hit(origin, direction);
  if (!hit) return {};
  const Vec3f n = dot(hit->normal, direction) > 0 ? -hit->normal : hit->normal;  // facing the camera: walls are single-sided
  const float light = kAmbient + kHeadlight * -dot(n, direction) + kFromAbove * std::max(0.f, n.z);
  const Vec3d in_cam = view.cam_from_world.rotation * cast<double>(n);
  return {light * kClay, {float(0.5 + 0.5 * in_cam.x), float(0.5 - 0.5 * in_cam.y), float(0.5 - 0.5 * in_cam.z)}};
}

}  // namespace

SurfaceView surface_view(const MeshHits& mesh, const View& original, int max_side) {
  View view = original;
  view.intrinsics = original.intrinsics.limited_to(max_side);
  const int width = view.intrinsics.width, height = view.intrinsics.height;
  const Vec3f origin = cast<float>(view.centre_in_world());
  SurfaceView out{Image8(width, height, 3), Image8(width, height, 3)};
  parallel_for(size_t(height), 4, [&](size_t row) {
    const int y = int(row);
    for (int x = 0; x < width; ++x) {
      Vec3f clay{}, normal{};
      for (int s = 0; s < kSubpixels * kSubpixels; ++s) {
        const Shades one =
            shades_of(mesh, view, origin, x + (s % kSubpixels + 0.5) / kSubpixels, y + (s / kSubpixels + 0.5) / kSubpixels);
        clay += one.clay;
        normal += one.normal;
      }
      for (size_t c = 0; c < 3; ++c) {
        constexpr float kScale = 255.f / (kSubpixels * kSubpixels);
        out.clay.pixel(x, y)[c] = uint8_t(std::clamp(kScale * clay[c] + 0.5f, 0.f, 255.f));
        out.normals.pixel(x, y)[c] = uint8_t(std::clamp(kScale * normal[c] + 0.5f, 0.f, 255.f));
      }
    }
  });
  return out;
}

}  // namespace vitrine
