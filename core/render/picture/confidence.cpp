#include "core/render/picture/confidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/render/picture/surfel_colors.h"
#include "core/render/raster/renderer.h"
#include "core/scene/camera/projection.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr int kSide = 320;  // resolution of the occlusion pictures, pixels
constexpr double kSeenShare = 0.05;
constexpr double kHalfError = 0.05;  // sRGB error that halves the confidence
constexpr double kHalfPixels = 1;    // so does a sum of weights of one pixel
constexpr size_t kGrain = 1024;

// The weights of the surfels are all that is needed of the pass.
RasterDesc plain_pass(const View& view, float near_z) {
  return {.intrinsics = view.intrinsics,
          .cam_from_world = view.cam_from_world,
          .features = FeatureSet::ColorOnly,
          .sh_degree = 0,
          .near_z = near_z};
}

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
  const RasterDesc desc = plain_pass(photo, near_z);
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

std::vector<PhotoCoverage> photo_coverage(const SplatLayer& layer, size_t solid, std::span<const View> photos, float near_z) {
  const size_t n = layer.size();
  SplatLayer opaque = layer;
  opaque.resize(solid);
  const auto renderer = make_renderer(Backend::Cpu);
  std::vector<uint8_t> seen(photos.size() * n);
  std::vector<Vec3d> eyes;
  for (size_t v = 0; v < photos.size(); ++v) {
    throw_if_interrupted();
    View photo = photos[v];
    photo.intrinsics = photo.intrinsics.limited_to(kSide);
    eyes.push_back(photo.centre_in_world());
    const auto row = std::span(seen).subspan(v * n, n);
    mark_seen(opaque, 0, photo, near_z, *renderer, row);
    if (n > solid) mark_seen(layer, solid, photo, near_z, *renderer, row);
  }
  std::vector<PhotoCoverage> out(n);
  parallel_for(n, kGrain, [&](size_t i) {
    const float* m = layer.at(Attribute::Mean, i);
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

std::vector<float> confidence_of(const TrainingEvidence& evidence) {
  std::vector<float> out(evidence.weight.size());
  for (size_t i = 0; i < out.size(); ++i) {
    const double weight = evidence.weight[i];
    if (weight > 0) out[i] = float(kHalfError / (kHalfError + evidence.error[i] / weight) * weight / (weight + kHalfPixels));
  }
  return out;
}

std::vector<float> surfel_confidence(ScenePainter& painter, std::span<const View> training,
                                     const std::function<ImageF(const View&)>& photo_of) {
  const SplatLayer& diffuse = painter.surfels().diffuse;
  const size_t n = diffuse.size();
  const auto renderer = make_renderer(Backend::Cpu);
  TrainingEvidence evidence{std::vector<double>(n), std::vector<double>(n)};
  SplatLayer unused = diffuse.zeros_like();
  RasterImages images, gradients;
  for (View view : training) {
    throw_if_interrupted();
    view.intrinsics = view.intrinsics.limited_to(kSide);
    const ImageF error = absolute_error(painter.picture(view).srgb, photo_of(view));
    const RasterDesc desc = plain_pass(view, painter.image().diffuse.near_z);
    renderer->forward(diffuse, desc, images);
    gradients.reset(desc);
    SurfelStatistics statistics;
    renderer->backward({.gradients = &gradients, .error_image = error.data()}, unused, &statistics);
    for (size_t i = 0; i < n; ++i) evidence.weight[i] += statistics.weight[i], evidence.error[i] += statistics.error[i];
  }
  return confidence_of(evidence);
}

ImageF confidence_map(const SplatLayer& diffuse, std::span<const float> confidence, float near_z, const View& view) {
  std::vector<Vec3f> grey;
  for (const float c : confidence) grey.push_back({c, c, c});
  const ImageF picture = SurfelColors(diffuse, grey, near_z).picture(view);
  ImageF out(picture.width(), picture.height(), 1);
  for (size_t i = 0; i < out.pixel_count(); ++i) out.data()[i] = picture.data()[3 * i];
  return out;
}

ImageF absolute_error(const ImageF& srgb, const ImageF& reference) {
  ImageF out(srgb.width(), srgb.height(), 1);
  const size_t channels = size_t(srgb.channels());
  for (size_t i = 0; i < out.pixel_count(); ++i) {
    double sum = 0;
    for (size_t c = 0; c < channels; ++c)
      sum += std::abs(double(srgb.data()[channels * i + c]) - reference.data()[channels * i + c]);
    out.data()[i] = float(sum / double(channels));
  }
  return out;
}

}  // namespace vitrine
