#include "stages/sfm/gains/rig_adjustment.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/foundation/base/rng.h"

namespace vitrine {
namespace {

constexpr size_t kRigs = 5;
constexpr uint32_t kViewsOfRig = 4;  // all around, at right angles

struct RigScene {
  ColmapModel truth, start;
  std::vector<RigCamera> cameras;
};

Mat3d turned(double angle) {  // about the camera's y
  return {{std::cos(angle), 0, -std::sin(angle)}, {0, 1, 0}, {std::sin(angle), 0, std::cos(angle)}};
}

// Rigs of four views each in a cloud of points, observed with a noise of `noise` pixels. The start: shifted, turned poses.
RigScene rig_scene(double noise) {
  Rng rng(5);
  RigScene s;
  s.truth.cameras.push_back({.id = 1, .model_id = 0, .width = 200, .height = 200, .params = {100, 100, 100}});
  for (uint64_t p = 1; p <= 400; ++p) {
    const Vec3d d = normalized(Vec3d{rng.normal(), 0.2 * rng.normal(), rng.normal()});
    s.truth.points.push_back({.id = p, .position = (2 + double(rng.uniform())) * d, .track = {}});
  }
  for (uint32_t r = 0; r < kRigs; ++r) {
    const double a = 2 * std::numbers::pi * r / kRigs;
    const Rigid body = inverse(Rigid{turned(0.4 * r), {std::cos(a), 0.2 * (r % 2), std::sin(a)}});
    for (uint32_t v = 0; v < kViewsOfRig; ++v) {
      const Rigid pose = Rigid{turned(0.5 * std::numbers::pi * v), {}} * body;
      ColmapImage image{.id = kViewsOfRig * r + v + 1,
                        .rotation = quaternion(pose.rotation),
                        .translation = pose.translation,
                        .camera_id = 1,
                        .name = fmt::format("{}_{}.png", r, v),
                        .points = {}};
      for (ColmapPoint3D& point : s.truth.points) {
        const Vec3d q = pose * point.position;
        if (q.z < 0.1 || std::abs(q.x) > q.z || std::abs(q.y) > q.z) continue;
        point.track.push_back({image.id, uint32_t(image.points.size())});
        image.points.push_back(
            {100 + 100 * q.x / q.z + noise * rng.normal(), 100 + 100 * q.y / q.z + noise * rng.normal(), point.id});
      }
      s.truth.images.push_back(std::move(image));
      s.cameras.push_back({r, quaternion(turned(0.5 * std::numbers::pi * v))});
    }
  }
  s.start = s.truth;
  for (ColmapPoint3D& point : s.start.points) point.position += 0.02 * Vec3d{rng.normal(), rng.normal(), rng.normal()};
  for (uint32_t r = 2; r < kRigs; ++r)  // the first two keep the frame and the scale
    for (uint32_t v = 0; v < kViewsOfRig; ++v) {
      ColmapImage& image = s.start.images[kViewsOfRig * r + v];
      const Rigid moved = image.cam_from_world() * Rigid{turned(0.02), {0.03, -0.02, 0.01}};
      image.rotation = quaternion(moved.rotation), image.translation = moved.translation;
    }
  return s;
}

TEST(RigAdjustment, FindsThePosesOfRigsWhoseViewsKeepOneCentre) {
  for (double noise : {0.0, 0.3}) {
    const RigScene s = rig_scene(noise);
    ColmapModel model = s.start;
    const RigAdjustment a = adjust_rigs(model, s.cameras);
    EXPECT_GT(a.error_before, 1);
    // Each rig sees each point once: of its ten residuals three are lost to its position.
    const double left = std::sqrt(1 - 3.0 / (2 * kRigs));
    EXPECT_NEAR(a.error_after, left * noise * std::sqrt(2.0), 0.001 + 0.1 * noise);
    // Scale is free: compare with the distance of the first two rigs.
    const auto centre = [](const ColmapModel& m, size_t i) { return inverse(m.images[i].cam_from_world()).translation; };
    const double scale =
        length(centre(model, kViewsOfRig) - centre(model, 0)) / length(centre(s.truth, kViewsOfRig) - centre(s.truth, 0));
    for (size_t i = 0; i < model.images.size(); ++i) {
      const Vec3d shift = centre(model, i) - centre(model, 0), expected = scale * (centre(s.truth, i) - centre(s.truth, 0));
      EXPECT_LT(length(shift - expected), 1e-4 + 0.02 * noise) << i;
      EXPECT_LT(length(centre(model, i) - centre(model, i - i % kViewsOfRig)), 1e-12) << i;
    }
    double error = 0;
    for (const ColmapPoint3D& p : model.points) error += p.error_px / double(model.points.size());
    EXPECT_NEAR(error, 1.25 * left * noise, 0.001 + 0.1 * noise) << "of the points, in pixels";
    ColmapModel again = s.start;
    adjust_rigs(again, s.cameras);
    EXPECT_TRUE(again == model) << "the same bytes";
  }
}

}  // namespace
}  // namespace vitrine
