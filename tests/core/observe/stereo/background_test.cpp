// What stands behind an object: exact planes or depths of a textured room, seen around a ball that mirrors it.
#include "core/observe/stereo/background.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/observe/stereo/textured_room.h"

namespace vitrine {
namespace {

constexpr int kRingViews = 16;
constexpr double kMirrorRadius = 0.15;
constexpr Vec3d kMirrorCentre{0, 0, kMirrorRadius};

// Floor z = 0 and walls of a square room; a ball on the floor.
struct Room {
  Room() {
    planes.push_back({.normal = {0, 0, 1}, .offset = 0, .share = 0.4, .centre = {0, 0, 0}, .extent = 1, .floor = true});
    for (const Vec3d& n : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0}})
      planes.push_back({.normal = n, .offset = -2, .share = 0.1, .centre = -2.0 * n, .extent = 1.5});
    for (int v = 0; v < kRingViews; ++v) {
      const double azimuth = 2 * std::numbers::pi * v / kRingViews;
      View view;
      view.name = fmt::format("view_{:02}.png", v);
      view.intrinsics = {96, 72, 120, 120, 48, 36};
      view.cam_from_world = textured_room::looking_at({std::cos(azimuth), std::sin(azimuth), 0.6}, {0, 0, 0.1});
      views.push_back(view);
      draw(view);
    }
  }

  // Distance along d, and encoded brightness.
  std::pair<double, double> wall(const Vec3d& eye, const Vec3d& d) const {
    double nearest = 1e300, brightness = 0;
    for (size_t p = 0; p < planes.size(); ++p) {
      const double t = (planes[p].offset - dot(planes[p].normal, eye)) / dot(planes[p].normal, d);
      if (!(t > 1e-9) || t >= nearest) continue;
      const Vec3d at = eye + t * d;
      nearest = t, brightness = textured_room::texture(0.4 * (p == 0 ? at.x : at.x + at.y), 0.4 * (p == 0 ? at.y : at.z), p + 1);
    }
    return {nearest, brightness};
  }
  void draw(const View& view) {
    const Intrinsics& k = view.intrinsics;
    EdgePhoto photo{view, ImageF(k.width, k.height, 3)};
    DepthMap map{.width = k.width, .height = k.height, .zdepth = {}, .normal = {}, .score = {}, .agreeing = {}, .trusted = {}};
    std::vector<uint8_t> ball;
    const Vec3d eye = view.centre_in_world();
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const Vec3d ray = view.ray(x + 0.5, y + 0.5), d = normalized(ray);
        const Vec3d from = eye - kMirrorCentre;
        const double b = dot(from, d), inside = b * b - dot(from, from) + kMirrorRadius * kMirrorRadius;
        const auto [distance, brightness] = wall(eye, d);
        double seen = brightness;
        if (inside > 0) {
          const Vec3d p = eye + (-b - std::sqrt(inside)) * d, n = (p - kMirrorCentre) / kMirrorRadius;
          seen = wall(p + 1e-6 * n, d - 2 * dot(d, n) * n).second;
        }
        for (int c = 0; c < 3; ++c) photo.srgb.at(x, y, c) = float(seen);
        map.zdepth.push_back(float(distance / length(ray)));
        map.trusted.push_back(inside <= 0);
        ball.push_back(inside > 0);
      }
    photos.push_back(std::move(photo));
    maps.push_back(std::move(map));
    truth.push_back(std::move(ball));
  }
  // Twice as wide as the ball.
  VisualHull loose_hull() const {
    std::vector<Silhouette> wide;
    for (const View& view : views) {
      const Vec3d centre = view.cam_from_world * kMirrorCentre;
      const double r = 2 * view.intrinsics.fx * kMirrorRadius / centre.z;
      std::vector<uint8_t> inside;
      for (int y = 0; y < view.intrinsics.height; ++y)
        for (int x = 0; x < view.intrinsics.width; ++x)
          inside.push_back(std::hypot(x + 0.5 - (view.intrinsics.fx * centre.x / centre.z + view.intrinsics.cx),
                                      y + 0.5 - (view.intrinsics.fy * centre.y / centre.z + view.intrinsics.cy)) < r);
      wide.push_back(silhouette(view, inside));
    }
    return VisualHull(wide,
                      {.resolution = 64, .within = sides_of_cameras(planes, views, {{-0.3, -0.3, -0.15}, {0.3, 0.3, 0.45}})});
  }
  std::vector<HullDepths> passed(const VisualHull& hull) const {
    std::vector<HullDepths> depths;
    for (const View& view : views) depths.push_back(hull_depths(hull, view));
    return depths;
  }

  std::vector<View> views;
  std::vector<EdgePhoto> photos;
  std::vector<DepthMap> maps;
  std::vector<ScenePlane> planes;
  std::vector<std::vector<uint8_t>> truth;  // [view][h,w] the ball
};

// Shares of the ball's pixels that are not explained, of the others in the hull that are, and of those nobody knows.
struct Shares {
  double ball = 0, past = 0, unknown = 0;
};
Shares shares_of(const Room& room, const Surroundings& scene) {
  const VisualHull hull = room.loose_hull();
  const std::vector<HullDepths> passed = room.passed(hull);
  size_t ball = 0, differs = 0, others = 0, explained = 0, unknown = 0;
  for (size_t v = 0; v < room.views.size(); v += 5) {
    const std::vector<float> error = unexplained(scene, hull, passed, v);
    for (size_t i = 0; i < error.size(); ++i) {
      EXPECT_EQ(passed[v].exit[i] == 0, passed[v].entry[i] == 0);
      if (passed[v].exit[i] == 0) {
        EXPECT_LT(error[i], 0);
        continue;
      }
      if (error[i] < 0) {
        ++unknown;
        continue;
      }
      (room.truth[v][i] ? ball : others) += 1;
      if (room.truth[v][i]) differs += error[i] >= 1;
      if (!room.truth[v][i]) explained += error[i] < 1;
    }
  }
  return {double(differs) / double(ball), double(explained) / double(others), double(unknown) / double(ball + others + unknown)};
}

TEST(Background, PlanesTellAMirrorFromWhatIsSeenPastIt) {
  const Room room;
  const std::vector<DepthMap> blind(room.maps.size());
  const Shares s = shares_of(room, {.photos = room.photos, .maps = blind, .planes = room.planes});
  EXPECT_GT(s.ball, 0.65);     // measured 0.69: what a mirror shows may look like what it hides
  EXPECT_GT(s.past, 0.85);     // 0.88
  EXPECT_LT(s.unknown, 0.35);  // 0.33: walls that few of these photos show
}

TEST(Background, DepthsOfOtherPhotosTellItWithoutPlanes) {
  const Room room;
  const Shares s = shares_of(room, {.photos = room.photos, .maps = room.maps, .planes = {}});
  EXPECT_GT(s.ball, 0.7);
  EXPECT_GT(s.past, 0.85);
}

TEST(Background, WithoutGeometryTheFarBackgroundExplainsLittleOfWhatIsNear) {
  const Room room;
  const std::vector<DepthMap> blind(room.maps.size());
  const Shares s = shares_of(room, {.photos = room.photos, .maps = blind, .planes = {}});
  EXPECT_LT(s.past, 0.45);  // measured 0.33: noise of the same brightness
}

TEST(Background, WithNothingTakenAwayAMirrorIsWhatNothingExplains) {
  const Room room;
  const Surroundings scene{.photos = room.photos, .maps = room.maps, .planes = room.planes};
  size_t ball = 0, differs = 0, others = 0, explained = 0;
  for (size_t v = 0; v < room.views.size(); v += 5) {
    const Explanation found = explanation(scene, v);
    for (size_t i = 0; i < found.around.size(); ++i) {
      EXPECT_EQ(found.around[i] < 0, found.depth[i] == 0);
      if (found.around[i] < 0) continue;
      (room.truth[v][i] ? ball : others) += 1;
      if (room.truth[v][i]) differs += found.around[i] >= 1;
      if (room.truth[v][i] || found.around[i] >= 1) continue;
      ++explained;
      EXPECT_NEAR(found.depth[i] / room.maps[v].zdepth[i], 1, 0.3);
    }
  }
  EXPECT_GT(double(differs) / double(ball), 0.6);
  EXPECT_GT(double(explained) / double(others), 0.85);
}

TEST(Background, AThingOnAFloorIsNotBelowIt) {
  const Room room;
  const std::vector<HalfSpace> sides = sides_of_cameras(room.planes, room.views, {{-0.3, -0.3, -0.2}, {0.3, 0.3, 0.4}});
  ASSERT_EQ(sides.size(), 1u);  // walls are too far away
  EXPECT_LT(dot(sides[0].normal, Vec3d{0, 0, 0.1}), sides[0].offset);
  EXPECT_GT(dot(sides[0].normal, Vec3d{0, 0, -0.1}), sides[0].offset);
  std::vector<ScenePlane> pedestal = room.planes;
  pedestal.push_back({.normal = {0, 0, 1}, .offset = 0.1, .share = 0.1, .centre = {0.2, 0, 0.1}, .extent = 0.6});
  const auto beside = sides_of_cameras(pedestal, room.views, {{-0.3, -0.3, -0.2}, {0.3, 0.3, 0.4}});
  ASSERT_EQ(beside.size(), 1u);
  EXPECT_EQ(beside[0].offset, sides[0].offset);
  std::vector<ScenePlane> small = room.planes;
  small[0].extent = 0.2;  // smaller than the thing
  EXPECT_TRUE(sides_of_cameras(small, room.views, {{-0.3, -0.3, -0.2}, {0.3, 0.3, 0.4}}).empty());
  EXPECT_GT(room.loose_hull().bounds().low.z, -0.03);
}

TEST(Background, AHullIsHiddenWhereStereoFoundASurfaceBeforeIt) {
  const Room room;
  const HullDepths passed = hull_depths(room.loose_hull(), room.views[0]);
  DepthMap map = room.maps[0];
  map.trusted.assign(map.trusted.size(), 1);
  const size_t middle = map.index(48, 34);
  ASSERT_GT(passed.entry[middle], 0);
  EXPECT_LT(passed.entry[middle], passed.exit[middle]);
  EXPECT_EQ(hidden_pixels(map, passed)[middle], 0);
  map.zdepth[middle] = 0.9f * passed.entry[middle];
  EXPECT_EQ(hidden_pixels(map, passed)[middle], 1);
  map.trusted[middle] = 0;
  EXPECT_EQ(hidden_pixels(map, passed)[middle], 0);
}

}  // namespace
}  // namespace vitrine
