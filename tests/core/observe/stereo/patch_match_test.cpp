#include "core/observe/stereo/patch_match.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/observe/stereo/patch_score.h"
#include "core/observe/stereo/scene_planes.h"
#include "tests/core/observe/stereo/textured_room.h"

namespace vitrine {
namespace {

using namespace textured_room;

struct Quality {
  double reliable = 0, exact = 0, turned_right = 0;  // shares of all pixels, of the reliable ones, of the exact ones
};

Quality quality(const StereoPhoto& photo, const DepthMap& map) {
  size_t reliable = 0, exact = 0, turned_right = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const size_t i = map.index(x, y);
      if (!map.reliable(i)) continue;
      ++reliable;
      const Hit hit = truth(photo, x, y);
      if (std::abs(double(map.zdepth[i]) / hit.t - 1) > 0.01) continue;
      ++exact;
      turned_right += dot(cast<double>(map.normal[i]), hit.normal) > 0.9;
    }
  return {double(reliable) / double(map.zdepth.size()), double(exact) / double(reliable), double(turned_right) / double(exact)};
}

TEST(PatchScore, IsOneOnTheTruePlaneAndLowerOffIt) {
  const std::vector<StereoPhoto> room = photos();
  const StereoPhoto& photo = room[2];
  const Intrinsics& k = photo.view.intrinsics;
  const Transfer transfer = transfer_between(photo.view, room[1].view);
  const int x = 40, y = 55;
  const Hit hit = truth(photo, x, y);
  const ReferencePatch patch = reference_patch(photo.luma, x, y);
  const auto score_at = [&](double z) {
    const Vec3d n = hit.normal / (z * dot(hit.normal, k.ray(x + 0.5, y + 0.5)));
    return patch_score(patch, room[1].luma, transfer, {n.x / k.fx, n.y / k.fy, n.z - n.x * k.cx / k.fx - n.y * k.cy / k.fy},
                       x + 0.5, y + 0.5);
  };
  EXPECT_GT(score_at(hit.t), 0.97f);
  EXPECT_LT(score_at(1.1 * hit.t), 0.8f);
  EXPECT_LT(score_at(0.9 * hit.t), 0.8f);
}

TEST(PatchMatch, FindsATableAndAWall) {
  const std::vector<StereoPhoto> room = photos();
  std::vector<DepthMap> maps = patch_match(room, {.seed = 3});
  count_agreement(room, maps);
  for (size_t v = 0; v < room.size(); ++v) {
    const Quality q = quality(room[v], maps[v]);
    EXPECT_GT(q.reliable, 0.75) << v;
    EXPECT_GT(q.exact, 0.92) << v;
    EXPECT_GT(q.turned_right, 0.8) << v;
  }
}

TEST(PatchMatch, SameBytesForAnyNumberOfThreads) {
  const std::vector<StereoPhoto> room = photos();
  std::vector<DepthMap> first;
  for (int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    std::vector<DepthMap> maps = patch_match(room, {.iterations = 2, .seed = 3});
    count_agreement(room, maps);
    if (first.empty()) first = maps;
    for (size_t v = 0; v < maps.size(); ++v) {
      EXPECT_EQ(maps[v].zdepth, first[v].zdepth);
      EXPECT_EQ(maps[v].score, first[v].score);
      EXPECT_EQ(maps[v].agreeing, first[v].agreeing);
    }
  }
  set_thread_limit(0);
}

TEST(PatchMatch, HasNoReliablePixelWhereThereIsNothingToSee) {
  std::vector<StereoPhoto> room = photos();
  for (StereoPhoto& photo : room) std::fill(photo.luma.data().begin(), photo.luma.data().end(), 0.5f);
  std::vector<DepthMap> maps = patch_match(room, {.iterations = 1});
  count_agreement(room, maps);
  for (const DepthMap& map : maps)
    for (size_t i = 0; i < map.zdepth.size(); ++i) ASSERT_FALSE(map.reliable(i));
  room[0].neighbours.clear();
  EXPECT_TRUE(patch_match(room, {.iterations = 1})[0].zdepth.empty());
}

TEST(ScenePlanes, AreTheFloorAndTheWall) {
  const std::vector<StereoPhoto> room = photos();
  std::vector<DepthMap> maps = patch_match(room, {.seed = 3});
  count_agreement(room, maps);
  const std::vector<ScenePlane> planes = scene_planes(room, maps);
  ASSERT_GE(planes.size(), 2u);
  const bool floor_first = std::abs(planes[0].normal.z) > std::abs(planes[0].normal.x);
  const ScenePlane &floor = planes[floor_first ? 0 : 1], &wall = planes[floor_first ? 1 : 0];
  EXPECT_GT(std::abs(floor.normal.z), std::cos(0.5 * std::numbers::pi / 180));
  EXPECT_NEAR(floor.offset / floor.normal.z, 0, 0.003);
  EXPECT_GT(std::abs(wall.normal.x), std::cos(0.5 * std::numbers::pi / 180));
  EXPECT_NEAR(wall.offset / wall.normal.x, -0.5, 0.003);
  for (const ScenePlane* plane : {&floor, &wall}) {
    EXPECT_NEAR(dot(plane->normal, plane->centre), plane->offset, 0.003);
    EXPECT_GT(plane->extent, 0.2);
    EXPECT_LT(plane->extent, 1);
  }
  EXPECT_TRUE(floor.floor);
  EXPECT_FALSE(wall.floor);
  EXPECT_GT(planes[0].share + planes[1].share, 0.9);
  EXPECT_GE(planes[0].share, planes[1].share);
  for (size_t p = 2; p < planes.size(); ++p) EXPECT_LT(planes[p].share, 0.05);  // nothing else is there
}

TEST(ExtendPlanes, SameBytesForAnyNumberOfThreads) {
  const std::vector<StereoPhoto> room = photos(0.25);
  std::vector<DepthMap> maps = patch_match(room, {.iterations = 2, .seed = 3});
  count_agreement(room, maps);
  std::vector<float> first;
  for (int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    const std::vector<float> zdepth = extended(room, maps, scene_planes(room, maps), 1).zdepth;
    if (first.empty()) first = zdepth;
    EXPECT_EQ(zdepth, first);
  }
  set_thread_limit(0);
}

TEST(ExtendPlanes, NothingStandsBeforeWhatOthersSee) {
  // The middle photo forgets the wall and is left with the floor, which goes on below it: the others are sure of the wall.
  const std::vector<StereoPhoto> room = photos();
  std::vector<DepthMap> maps = patch_match(room, {.seed = 3});
  count_agreement(room, maps);
  size_t forgotten = 0, right = 0;
  const std::vector<ScenePlane> planes = scene_planes(room, maps);
  const Vec3d wall_normal = room[2].view.cam_from_world.rotation * Vec3d{1, 0, 0};
  for (int y = 0; y < maps[2].height; ++y)
    for (int x = 0; x < maps[2].width; ++x)
      if (dot(truth(room[2], x, y).normal, wall_normal) > 0.99) maps[2].trusted[maps[2].index(x, y)] = 0, ++forgotten;
  const DepthMap map = extended(room, maps, planes, 2);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const Hit hit = truth(room[2], x, y);
      if (dot(hit.normal, wall_normal) > 0.99) right += std::abs(double(map.zdepth[map.index(x, y)]) / hit.t - 1) < 0.02;
    }
  ASSERT_GT(forgotten, 1000u);
  EXPECT_GT(right, forgotten * 93 / 100);  // the foot of the wall may pass for floor
}

TEST(ExtendPlanes, NothingIsSeenThroughTheFloor) {
  // One photo without a witness, which knows the wall and the rear of the floor: what lies below is neither wall nor far away.
  const std::vector<StereoPhoto> room = photos();
  std::vector<DepthMap> maps = patch_match(room, {.seed = 3});
  count_agreement(room, maps);
  std::vector<ScenePlane> planes = scene_planes(room, maps);
  for (size_t v = 0; v < maps.size(); ++v)
    if (v != 2) maps[v] = {};
  DepthMap& own = maps[2];
  for (int y = own.height * 2 / 3; y < own.height; ++y)
    for (int x = 0; x < own.width; ++x) own.trusted[own.index(x, y)] = 0;
  const auto expect_nothing_behind = [&] {
    const DepthMap map = extended(room, maps, planes, 2);
    for (int y = own.height * 2 / 3; y < own.height; ++y)
      for (int x = 0; x < own.width; ++x)
        ASSERT_LT(double(map.zdepth[map.index(x, y)]) / truth(room[2], x, y).t, 1.03) << x << " " << y;
  };
  expect_nothing_behind();
  // However little of it was found.
  ASSERT_TRUE(std::ranges::any_of(planes, &ScenePlane::floor));
  for (ScenePlane& plane : planes) plane.centre = {-0.4, 0, 0}, plane.extent = 0.02;
  expect_nothing_behind();
}

TEST(ExtendPlanes, NothingStandsAroundACamera) {
  // Plaster has no texture: a plane in mid-air explains it as well as the wall does, which few pixels below it show.
  constexpr double kPlainFrom = 0.25, kInAir = 0.05;
  std::vector<StereoPhoto> room = photos(kPlainFrom);
  std::vector<DepthMap> maps = patch_match(room, {.seed = 3});
  count_agreement(room, maps);
  std::vector<ScenePlane> planes{{.normal = {1, 0, 0}, .offset = kInAir, .centre = {kInAir, 0, 0.5}, .extent = 1}};
  const StereoPhoto& photo = room[2];
  const Rigid world_from_cam = inverse(photo.view.cam_from_world);
  const Vec3d camera{kInAir, 0, 0.55};
  // Share of the plaster behind the neighbourhood of `camera` that is put on the plane in mid-air.
  const auto chosen = [&] {
    const DepthMap map = extended(room, maps, planes, 2);
    double plain = 0, in_air = 0;
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) {
        const Vec3d d = world_from_cam.rotation * photo.view.intrinsics.ray(x + 0.5, y + 0.5), &o = world_from_cam.translation;
        const double t_air = (kInAir - o.x) / d.x, t_wall = (-0.5 - o.x) / d.x;
        const size_t pixel = map.index(x, y);
        if ((o + t_wall * d).z < kPlainFrom + 0.05 || map.reliable(pixel) || length(o + t_air * d - camera) > 0.3) continue;
        plain += 1, in_air += std::abs(double(map.zdepth[pixel]) / t_air - 1) < 0.02;
      }
    EXPECT_GT(plain, 300);
    return in_air / plain;
  };
  EXPECT_GT(chosen(), 0.5);
  // Found on a small thing elsewhere, such as a facet of something round, it is no wall.
  planes[0].centre = {kInAir, 3, 0.5}, planes[0].extent = 0.1;
  EXPECT_LT(chosen(), 0.01);
  planes[0].centre = {kInAir, 0, 0.5}, planes[0].extent = 1;
  // A camera there that looks the other way sees none of it.
  StereoPhoto away = photo;
  away.view.cam_from_world = looking_at(camera, {2, 0, 0.55});
  away.near_z = 0.4;
  DepthMap nothing_sure = maps[2];
  std::ranges::fill(nothing_sure.trusted, uint8_t(0));
  room.push_back(away);
  maps.push_back(nothing_sure);
  EXPECT_LT(chosen(), 0.01);
}

TEST(ExtendPlanes, PlasterContinuesTheWall) {
  constexpr double kPlainFrom = 0.25;
  const std::vector<StereoPhoto> room = photos(kPlainFrom);
  std::vector<DepthMap> maps = patch_match(room, {.seed = 3});
  count_agreement(room, maps);
  const StereoPhoto& photo = room[2];
  const DepthMap map = extended(room, maps, scene_planes(room, maps), 2);
  EXPECT_EQ(map.trusted, maps[2].trusted);
  size_t plain = 0, right = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const Hit hit = truth(photo, x, y);
      const Rigid world_from_cam = inverse(photo.view.cam_from_world);
      const Vec3d p = world_from_cam * (hit.t * photo.view.intrinsics.ray(x + 0.5, y + 0.5));
      if (p.x > -0.49 || p.z < kPlainFrom + 0.05 || map.reliable(map.index(x, y))) continue;
      ++plain;
      right += std::abs(double(map.zdepth[map.index(x, y)]) / hit.t - 1) < 0.02;
    }
  ASSERT_GT(plain, 300u);
  EXPECT_GT(right, plain * 97 / 100);
}

// A shell at the end of where surfaces are looked for moves from photo to photo; the sky does not.
TEST(ExtendPlanes, TheSkyIsAtTheBackground) {
  constexpr double kWallTo = 0.2, kBackground = 100;
  std::vector<StereoPhoto> room = photos(1e9, kWallTo);
  const auto found = [&] {
    std::vector<DepthMap> maps = patch_match(room, {.seed = 3});
    count_agreement(room, maps);
    const DepthMap map = extended(room, maps, scene_planes(room, maps), 2);
    struct {
      size_t sky = 0, far = 0, wall = 0, right = 0;
    } count;
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) {
        const double z = double(map.zdepth[map.index(x, y)]);
        const Hit hit = truth(room[2], x, y, kWallTo);
        if (hit.t == kSky)
          ++count.sky, count.far += z > 0.99 * kBackground;
        else if (hit.normal.z < -0.5)
          ++count.wall, count.right += std::abs(z / hit.t - 1) < 0.02;
      }
    return count;
  };
  for (StereoPhoto& photo : room) photo.background_z = kBackground;
  const auto count = found();
  ASSERT_GT(count.sky, 1000u);
  ASSERT_GT(count.wall, 500u);
  EXPECT_GT(count.far, count.sky * 8 / 10) << count.sky;  // its border is shared with the wall
  EXPECT_GT(count.right, count.wall * 9 / 10) << count.wall;
}

TEST(StereoNeighbours, PrefersPhotosThatShareManyPointsUnderAUsefulAngle) {
  ViewSet set;
  for (double azimuth : {0.0, 0.002, 0.3, 0.6, 2.5}) {
    View view;
    view.cam_from_world = looking_at({std::cos(azimuth), std::sin(azimuth), 0.5}, {0, 0, 0});
    set.views.push_back(view);
  }
  for (int i = 0; i < 10; ++i) set.points.push_back({.position = {0.01 * i, 0, 0}, .linear_rgb = {}, .views = {0, 1, 2, 3}});
  for (int i = 0; i < 5; ++i) set.points.push_back({.position = {0, 0.01 * i, 0}, .linear_rgb = {}, .views = {0, 2}});
  const std::vector<uint32_t> all{0, 1, 2, 3, 4};
  const auto found = stereo_neighbours(set, all, 2);
  EXPECT_EQ(found[0], (std::vector<uint32_t>{2, 3}));  // 1 stands too close, 4 shares nothing
  const std::vector<uint32_t> some{0, 1, 4};
  EXPECT_EQ(stereo_neighbours(set, some, 5)[0], (std::vector<uint32_t>{1, 4}));  // then the nearest
}

}  // namespace
}  // namespace vitrine
