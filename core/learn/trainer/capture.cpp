#include "core/learn/trainer/capture.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/holdout.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

Intrinsics level_intrinsics(const Intrinsics& photo, int max_side, size_t level) {
  const Intrinsics full = photo.limited_to(max_side);
  const int divisor = 1 << level;
  return photo.scaled_to(std::max(1, full.width / divisor), std::max(1, full.height / divisor));
}

std::vector<uint16_t> encoded(const ImageF& linear) {
  const ImageF srgb = srgb_from_linear_image(linear);
  const size_t pixels = srgb.pixel_count();
  std::vector<uint16_t> planes(3 * pixels);
  const auto data = srgb.data();
  for (size_t i = 0; i < pixels; ++i)
    for (size_t c = 0; c < 3; ++c)
      planes[c * pixels + i] = static_cast<uint16_t>(std::lround(std::clamp(data[3 * i + c], 0.f, 1.f) * 65535.f));
  return planes;
}

}  // namespace

PhotoPyramid make_photo(const View& view, const ImageF& linear, int max_side) {
  PhotoPyramid photo;
  ImageF image = linear;
  for (size_t level = 0; level < kLevels; ++level) {
    PhotoLevel& l = photo.levels[level];
    l.view = view;
    l.view.intrinsics = level_intrinsics(view.intrinsics, max_side, level);
    if (image.width() != l.view.intrinsics.width || image.height() != l.view.intrinsics.height)
      image = resized(image, l.view.intrinsics.width, l.view.intrinsics.height);
    l.srgb = encoded(image);
  }
  return photo;
}

Vec3f linear_at(const PhotoLevel& photo, size_t pixel) {
  const size_t pixels = photo.srgb.size() / 3;
  Vec3f linear;
  for (size_t c = 0; c < 3; ++c)
    linear[c] = linear_from_srgb(float(photo.srgb[c * pixels + pixel]) / 65535.f) / float(photo.view.gain[c]);
  return linear;
}

void decode(const PhotoLevel& level, std::vector<float>& srgb) {
  srgb.resize(level.srgb.size());
  constexpr size_t kChunk = 1 << 16;
  parallel_chunks(srgb.size(), kChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) srgb[i] = static_cast<float>(level.srgb[i]) * (1.f / 65535.f);
  });
}

void raise_clipped(std::span<const float> prediction_srgb, std::span<float> target_srgb) {
  constexpr size_t kChunk = 1 << 16;
  parallel_chunks(target_srgb.size(), kChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (target_srgb[i] >= kClippedSrgb) target_srgb[i] = std::max(target_srgb[i], prediction_srgb[i]);
  });
}

size_t pyramid_bytes(const ViewSet& view_set, int max_side) {
  size_t bytes = 0;
  for (const View& view : view_set.views)
    for (size_t level = 0; level < kLevels; ++level) {
      const Intrinsics k = level_intrinsics(view.intrinsics, max_side, level);
      bytes += 3 * sizeof(uint16_t) * static_cast<size_t>(k.width) * static_cast<size_t>(k.height);
    }
  return bytes;
}

float near_plane(const ViewSet& set) {
  constexpr float kLeast = 0.01f, kMost = 0.1f, kPart = 0.5f;
  constexpr double kQuantile = 0.01;
  std::vector<float> depths;
  for (const View& view : set.views)
    for (const auto& point : set.points)
      if (const auto at = image_point(point.position, view)) depths.push_back(float(at->z));
  if (depths.empty()) return kLeast;
  return std::clamp(kPart * quantile_of(depths, kQuantile), kLeast, kMost);
}

namespace {

PhotoPyramid read_photo(const std::filesystem::path& sfm_folder, const View& view, int max_side) {
  const auto path = linear_image_path(sfm_folder, view);
  const ImageF linear = read_exr_rgb(path);
  const Intrinsics& k = view.intrinsics;
  if (linear.width() != k.width || linear.height() != k.height)
    throw Error(ErrorKind::Input, "a photo and its camera have different sizes",
                {.where = path.string(),
                 .why = fmt::format("the file has {} x {} pixels, the camera model {} x {}", linear.width(), linear.height(),
                                    k.width, k.height),
                 .hint = "run the sfm stage again",
                 .code = "SIZE_MISMATCH"});
  return make_photo(view, linear, max_side);
}

void read_photos(const std::filesystem::path& sfm_folder, int max_side, Capture& capture) {
  const auto& views = capture.view_set.views;
  capture.photos.resize(views.size());
  parallel_for(views.size(), 1, [&](size_t i) {
    if (interrupt_signal() == 0) capture.photos[i] = read_photo(sfm_folder, views[i], max_side);
  });
  throw_if_interrupted();
  for (const PhotoPyramid& photo : capture.photos)
    capture.largest_pixel_count = std::max(capture.largest_pixel_count, photo.levels[0].srgb.size() / 3);
  capture.memory_bytes = pyramid_bytes(capture.view_set, max_side);
}

}  // namespace

ViewSet part_of(const ViewSet& whole, std::span<const uint8_t> wanted) {
  ViewSet part{.views = {}, .points = {}, .scene_from_colmap = whole.scene_from_colmap};
  std::vector<uint32_t> number(whole.views.size(), 0);
  for (size_t v = 0; v < whole.views.size(); ++v) {
    number[v] = static_cast<uint32_t>(part.views.size());
    if (wanted[v]) part.views.push_back(whole.views[v]);
  }
  for (const ScenePoint& point : whole.points) {
    ScenePoint seen{point.position, point.linear_rgb, point.error_px, {}};
    for (uint32_t v : point.views)
      if (wanted[v]) seen.views.push_back(number[v]);
    if (!seen.views.empty()) part.points.push_back(std::move(seen));
  }
  return part;
}

Capture load_cameras(const std::filesystem::path& sfm_folder, int holdout_every) {
  Capture capture;
  capture.view_set = load_view_set(sfm_folder);
  const auto& views = capture.view_set.views;
  const std::vector<uint8_t> heldout = heldout_views(sfm_folder, views, holdout_every);
  for (size_t i = 0; i < views.size(); ++i) (heldout[i] ? capture.heldout : capture.train).push_back(static_cast<uint32_t>(i));
  if (capture.train.empty())
    throw Error(ErrorKind::Input, "no photo is left to train on",
                {.where = sfm_folder.string(),
                 .why = fmt::format("{} photos have poses and every {} is kept for the evaluation", views.size(), holdout_every),
                 .hint = "--set optimize.holdout_every=0, or take more photos",
                 .code = "NO_TRAINING_VIEW"});
  capture.near_z = near_plane(capture.view_set);
  return capture;
}

Capture load_capture(const std::filesystem::path& sfm_folder, int max_side, int holdout_every) {
  Capture capture = load_cameras(sfm_folder, holdout_every);
  read_photos(sfm_folder, max_side, capture);
  return capture;
}

void use_corrected_poses(const std::filesystem::path& optimize_folder, Capture& capture) {
  correct_poses(optimize_folder, capture.view_set.views);
  for (size_t i = 0; i < capture.photos.size(); ++i)
    for (PhotoLevel& level : capture.photos[i].levels) level.view.cam_from_world = capture.view_set.views[i].cam_from_world;
}

Capture load_part(const std::filesystem::path& sfm_folder, int max_side, int holdout_every, std::span<const uint8_t> wanted) {
  const Capture whole = load_cameras(sfm_folder, holdout_every);
  Capture part;
  part.view_set = part_of(whole.view_set, wanted);
  part.near_z = whole.near_z;
  uint32_t count = 0;
  std::vector<uint8_t> heldout(whole.view_set.views.size(), 0);
  for (uint32_t v : whole.heldout) heldout[v] = 1;
  for (size_t v = 0; v < heldout.size(); ++v)
    if (wanted[v]) (heldout[v] ? part.heldout : part.train).push_back(count++);
  read_photos(sfm_folder, max_side, part);
  return part;
}

std::vector<uint32_t> photo_order(std::span<const uint32_t> photos, uint64_t seed, uint64_t epoch) {
  constexpr uint64_t kOrderStream = 0x7401;
  std::vector<uint32_t> order(photos.begin(), photos.end());
  Rng rng(seed, mix64(kOrderStream, epoch));
  for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[rng.below(static_cast<uint32_t>(i + 1))]);
  return order;
}

}  // namespace vitrine
