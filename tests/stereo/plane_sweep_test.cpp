#include "core/stereo/plane_sweep.h"

#include <gtest/gtest.h>

#include <cmath>

#include <fmt/format.h>

#include "core/base/rng.h"

namespace vitrine {
namespace {

constexpr double kHeight = 0.1;  // the textured plane z = kHeight

// Smooth noise of three scales on the plane.
double texture(double x, double y) {
  double sum = 0.5;
  for (int octave = 0; octave < 3; ++octave) {
    const double f = 9.0 * (1 << octave), px = x * f, py = y * f;
    const auto value = [&](int64_t i, int64_t j) {
      return Rng(7, mix64(uint64_t(i + 4096), uint64_t(j + 4096)) + uint64_t(octave)).uniform_double() - 0.5;
    };
    const int64_t i = int64_t(std::floor(px)), j = int64_t(std::floor(py));
    const double u = px - double(i), v = py - double(j);
    sum += 0.3 *
           ((1 - v) * ((1 - u) * value(i, j) + u * value(i + 1, j)) + v * ((1 - u) * value(i, j + 1) + u * value(i + 1, j + 1)));
  }
  return std::clamp(sum, 0.0, 1.0);
}

Rigid looking_at_origin(const Vec3d& centre) {
  const Vec3d forward = normalized(-centre), right = normalized(cross(forward, Vec3d{0, 0, 1})), down = cross(forward, right);
  const Mat3d rotation = transposed(Mat3d{right, down, forward});
  return {rotation, -(rotation * centre)};
}

// Seven photos of the plane from an arc; the last one takes no part.
std::vector<SweepPhoto> plane_photos() {
  std::vector<SweepPhoto> photos;
  for (uint32_t v = 0; v < 7; ++v) {
    const double azimuth = 0.12 * v;
    SweepPhoto photo;
    photo.view.name = fmt::format("view_{}.png", v);
    photo.view.intrinsics = {160, 120, 180, 180, 79, 61};
    photo.view.cam_from_world = looking_at_origin({std::cos(azimuth), std::sin(azimuth), 0.8});
    const Intrinsics& k = photo.view.intrinsics;
    const Rigid world_from_cam = inverse(photo.view.cam_from_world);
    if (v < 6) photo.grey = ImageF(k.width, k.height, 1);
    for (int y = 0; y < photo.grey.height(); ++y)
      for (int x = 0; x < photo.grey.width(); ++x) {
        const Vec3d d = world_from_cam.rotation * k.ray(x + 0.5, y + 0.5);
        const double t = (kHeight - world_from_cam.translation.z) / d.z;
        const Vec3d hit = world_from_cam.translation + t * d;
        photo.grey.at(x, y) = float(texture(hit.x, hit.y));
      }
    photos.push_back(std::move(photo));
  }
  return photos;
}

TEST(PlaneSweep, FindsDepthAndNormalOfATexturedTable) {
  const std::vector<SweepPhoto> photos = plane_photos();
  const PlaneSweep sweep(photos);
  Rng rng(1);
  size_t found = 0, exact = 0, level = 0;
  constexpr size_t kTries = 60;
  for (size_t i = 0; i < kTries; ++i) {
    const double x = 20 + 120 * rng.uniform_double(), y = 20 + 80 * rng.uniform_double();
    const View& view = photos[2].view;
    const Rigid world_from_cam = inverse(view.cam_from_world);
    const Vec3d d = world_from_cam.rotation * view.intrinsics.ray(x, y);
    const double z = (kHeight - world_from_cam.translation.z) / d.z;  // ray(...) has z = 1
    const auto swept = sweep.at(2, x, y, 0.4, 4);
    if (!swept) continue;
    ++found;
    exact += std::abs(swept->zdepth / z - 1) < 0.02;
    level += swept->normal_in_world.z > 0.99;
  }
  EXPECT_GT(found, kTries * 8 / 10);
  EXPECT_GT(exact, found * 95 / 100);
  EXPECT_GT(level, found * 8 / 10);
}

TEST(PlaneSweep, SaysNothingAboutFlatPatchesAndAbsentPhotos) {
  std::vector<SweepPhoto> photos = plane_photos();
  EXPECT_FALSE(PlaneSweep(photos).at(6, 80, 60, 0.4, 4));
  for (SweepPhoto& photo : photos) std::fill(photo.grey.data().begin(), photo.grey.data().end(), 0.5f);
  EXPECT_FALSE(PlaneSweep(photos).at(2, 80, 60, 0.4, 4));
}

}  // namespace
}  // namespace vitrine
