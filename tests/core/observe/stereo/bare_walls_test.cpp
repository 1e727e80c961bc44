// Walls without texture: a table that stereo finds, in a room of bare walls or under the sky.
#include "core/observe/stereo/scene_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "tests/core/observe/stereo/textured_room.h"

namespace vitrine {
namespace {

constexpr int kRing = 14;
constexpr double kHalfTable = 0.4, kHalfRoom = 1.7, kRoomFloor = -0.7, kWallTop = 1.5;

struct BareRoom {
  // `walls`: false = the sky begins where they would stand.
  explicit BareRoom(bool walls) {
    for (int v = 0; v < kRing; ++v) {
      const double azimuth = 2 * std::numbers::pi * v / kRing + 0.1;
      StereoPhoto photo;
      photo.view.name = fmt::format("view_{:02}.png", v);
      photo.view.intrinsics = {160, 120, 150, 150, 80, 60};
      photo.view.cam_from_world =
          textured_room::looking_at({1.1 * std::cos(azimuth), 1.1 * std::sin(azimuth), 0.4 + 0.3 * (v % 2)}, {0, 0, 0.1});
      photo.near_z = 0.2, photo.far_z = 5, photo.background_z = 100;
      draw(photo, walls);
    }
  }

  void draw(StereoPhoto& photo, bool walls) {
    const Intrinsics& k = photo.view.intrinsics;
    photo.luma = ImageF(k.width, k.height, 1);
    DepthMap map{.width = k.width, .height = k.height, .zdepth = {}, .normal = {}, .score = {}, .agreeing = {}, .trusted = {}};
    const Vec3d eye = photo.view.centre_in_world();
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const Vec3d d = photo.view.ray(x + 0.5, y + 0.5);
        const double table = -eye.z / d.z;
        const Vec3d on_table = eye + table * d;
        const bool is_table = table > 0 && std::max(std::abs(on_table.x), std::abs(on_table.y)) < kHalfTable;
        photo.luma.at(x, y) = float(is_table ? textured_room::texture(on_table.x, on_table.y, 3) : around(eye, d, walls));
        map.zdepth.push_back(is_table ? float(table) : 1.f);
        map.trusted.push_back(is_table);
      }
    map.agreeing.assign(map.zdepth.size(), 3);
    map.normal.assign(map.zdepth.size(), Vec3f{0, 0, -1});
    photos.push_back(std::move(photo));
    maps.push_back(std::move(map));
  }

  static double around(const Vec3d& eye, const Vec3d& d, bool walls) {
    const Vec3d u = normalized(d);
    const double sky = 0.85 - 0.2 * u.z + 0.05 * u.x;
    if (!walls) return sky;
    const double floor = d.z < 0 ? (kRoomFloor - eye.z) / d.z : 1e9;
    const double tx = ((d.x > 0 ? kHalfRoom : -kHalfRoom) - eye.x) / d.x, ty = ((d.y > 0 ? kHalfRoom : -kHalfRoom) - eye.y) / d.y;
    const double t = std::min({floor, tx, ty});
    const Vec3d p = eye + t * d, from_lamp = p - Vec3d{0.3, -0.4, 1.3};
    if (t != floor && p.z > kWallTop) return sky;
    const double paint = t == floor ? 0.6 : t == tx ? (d.x > 0 ? 0.8 : 0.95) : (d.y > 0 ? 1.0 : 0.7);
    return paint / (1 + 0.15 * dot(from_lamp, from_lamp));
  }

  std::vector<StereoPhoto> photos;
  std::vector<DepthMap> maps;
  std::vector<ScenePlane> table{
      {.normal = {0, 0, 1}, .offset = 0, .share = 1, .centre = {0, 0, 0}, .extent = 0.5 * kHalfTable, .floor = false}};
};

TEST(BareWalls, AreTheWallsOfABareRoom) {
  const BareRoom room(true);
  const std::vector<ScenePlane> found = bare_walls(room.photos, room.maps, room.table);
  for (const Vec3d& wall : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0}}) {
    const auto it = std::ranges::find_if(found, [&](const ScenePlane& p) { return dot(p.normal, wall) > std::cos(0.02); });
    ASSERT_NE(it, found.end()) << wall.x << " " << wall.y;
    EXPECT_NEAR(it->offset, kHalfRoom, 0.03);
    EXPECT_LT(length(it->centre - kHalfRoom * wall), kHalfRoom);
    EXPECT_GT(it->extent, 0.3);
    EXPECT_FALSE(it->floor);
  }
  EXPECT_EQ(std::ranges::count(found, false, &ScenePlane::floor), 4);
}

TEST(BareWalls, HaveOneFloorUnlessStereoFoundIt) {
  BareRoom room(true);
  const std::vector<ScenePlane> found = bare_walls(room.photos, room.maps, room.table);
  ASSERT_EQ(std::ranges::count(found, true, &ScenePlane::floor), 1);
  const ScenePlane& floor = *std::ranges::find_if(found, &ScenePlane::floor);
  EXPECT_LT(floor.normal.z, -0.99);
  EXPECT_NEAR(floor.offset, -kRoomFloor, 0.05);
  room.table.push_back(
      {.normal = {0, 0, -1}, .offset = -kRoomFloor, .share = 0.1, .centre = {0, 0, kRoomFloor}, .extent = 1, .floor = true});
  const std::vector<ScenePlane> without = bare_walls(room.photos, room.maps, room.table);
  EXPECT_EQ(std::ranges::count(without, true, &ScenePlane::floor), 0);
}

TEST(BareWalls, AreNotSeenInTheSky) {
  const BareRoom room(false);
  EXPECT_TRUE(bare_walls(room.photos, room.maps, room.table).empty());
}

TEST(BareWalls, AreNotLookedForWhereStereoFindsEverything) {
  BareRoom room(true);
  for (DepthMap& map : room.maps) std::ranges::fill(map.trusted, uint8_t(1));
  EXPECT_TRUE(bare_walls(room.photos, room.maps, room.table).empty());
}

TEST(BareWalls, DoNotDependOnTheNumberOfThreads) {
  const BareRoom room(true);
  const auto found = [&](int threads) {
    set_thread_limit(threads);
    std::vector<ScenePlane> planes = bare_walls(room.photos, room.maps, room.table);
    set_thread_limit(0);
    return planes;
  };
  const std::vector<ScenePlane> one = found(1), three = found(3);
  ASSERT_EQ(one.size(), 5u);
  ASSERT_EQ(three.size(), 5u);
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].normal, three[i].normal);
    EXPECT_EQ(one[i].offset, three[i].offset);
  }
}

}  // namespace
}  // namespace vitrine
