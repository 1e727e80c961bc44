#include "stages/view/page_surfels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/projection.h"
#include "core/render/raster/renderer.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr int kSide = 320;  // resolution of the occlusion pictures, pixels
constexpr double kSeenShare = 0.05;
constexpr int kMostPhotos = 12;    // counts above this are clamped
constexpr double kAngleStep = 10;  // degrees
constexpr int kMostAngleSteps = 6;
constexpr size_t kGrain = 1024;

// Unoccluded blending weight of surfel i summed over the pixels, from the affine approximation of its projection; 0 if its centre
// is outside the image.
double unoccluded_weight(const SplatLayer& layer, size_t i, const View& view, double near_z) {
  const float *m = layer.at(Attribute::Mean, i), *q = layer.at(Attribute::Rotation, i), *s = layer.at(Attribute::LogScale, i);
  const Vec3d p = view.cam_from_world * Vec3d{m[0], m[1], m[2]};
  const Intrinsics& k = view.intrinsics;
  if (!image_point(p, k, near_z)) return 0;
  const Mat3d turned = view.cam_from_world.rotation * rotation_matrix(normalized(Quatd{q[0], q[1], q[2], q[3]}));
  const auto on_screen = [&](size_t axis) {
    const double span = std::exp(double(s[axis])) / p.z, along = turned(2, axis) / p.z;
    return Vec2d{k.fx * span * (turned(0, axis) - p.x * along), k.fy * span * (turned(1, axis) - p.y * along)};
  };
  const Vec2d u = on_screen(0), v = on_screen(1);
  const double low_pass = std::numbers::pi;  // lower bound from the screen-space low-pass filter (core/render/raster/README.md)
  return double(sigmoid(*layer.at(Attribute::Opacity, i))) *
         std::max(2 * std::numbers::pi * std::abs(u.x * v.y - u.y * v.x), low_pass);
}

// Marks the surfels [first, layer.size()) that the photo sees, in one row of `seen`.
void mark_seen(const SplatLayer& layer, size_t first, const View& photo, float near_z, Renderer& renderer,
               std::span<uint8_t> seen) {
  const RasterDesc desc{.intrinsics = photo.intrinsics,
                        .cam_from_world = photo.cam_from_world,
                        .features = FeatureSet::ColorOnly,
                        .sh_degree = 0,
                        .near_z = near_z};
  RasterImages images, gradients;
  renderer.forward(layer, desc, images);
  // The backward pass of the rasteriser accumulates the blending weight of each surfel; the gradients are zero.
  gradients.reset(desc);
  SplatLayer unused = layer.zeros_like();
  SurfelStatistics statistics;
  renderer.backward({.gradients = &gradients}, unused, &statistics);
  parallel_for(layer.size() - first, kGrain, [&](size_t k) {
    const size_t i = first + k;
    const double whole = unoccluded_weight(layer, i, photo, near_z);
    seen[i] = whole > 0 && statistics.weight[i] >= kSeenShare * whole;
  });
}

}  // namespace

std::vector<PhotoCoverage> photo_coverage(const PageSurfels& surfels, std::span<const View> photos, float near_z) {
  const size_t n = surfels.drawn;
  SplatLayer drawn = surfels.layer;
  drawn.resize(n);
  SplatLayer solid = drawn;
  solid.resize(surfels.solid);
  const auto renderer = make_renderer(Backend::Cpu);
  std::vector<uint8_t> seen(photos.size() * n);
  std::vector<Vec3d> eyes;
  for (size_t v = 0; v < photos.size(); ++v) {
    throw_if_interrupted();
    View photo = photos[v];
    photo.intrinsics = photo.intrinsics.limited_to(kSide);
    eyes.push_back(photo.centre_in_world());
    const auto row = std::span(seen).subspan(v * n, n);
    mark_seen(solid, 0, photo, near_z, *renderer, row);
    if (n > surfels.solid) mark_seen(drawn, surfels.solid, photo, near_z, *renderer, row);
  }
  std::vector<PhotoCoverage> out(n);
  parallel_for(n, kGrain, [&](size_t i) {
    const float* m = drawn.at(Attribute::Mean, i);
    std::vector<Vec3d> ways;
    for (size_t v = 0; v < photos.size(); ++v)
      if (seen[v * n + i]) ways.push_back(normalized(eyes[v] - Vec3d{m[0], m[1], m[2]}));
    double least = 1;
    for (size_t a = 0; a < ways.size(); ++a)
      for (size_t b = 0; b < a; ++b) least = std::min(least, dot(ways[a], ways[b]));
    out[i] = {static_cast<int>(ways.size()), std::acos(std::clamp(least, -1.0, 1.0)) * 180 / std::numbers::pi};
  });
  return out;
}

uint8_t coverage_byte(const PhotoCoverage& coverage) {
  const int steps = std::min(static_cast<int>(coverage.widest_deg / kAngleStep), kMostAngleSteps);
  return static_cast<uint8_t>(8 * std::min(coverage.photos, kMostPhotos) + steps);
}

void add_coverage(std::span<const PhotoCoverage> coverage, PageBlocks& blocks) {
  std::vector<uint8_t> bytes(coverage.size());
  std::ranges::transform(coverage, bytes.begin(), coverage_byte);
  blocks.bytes("seen", bytes, 1);
}

}  // namespace vitrine
