// Walls whose tops no photo shows: continued while the solved light above them is no brighter than they are.
#include "stages/decompose/wall_extension.h"

#include <cmath>

#include <gtest/gtest.h>

namespace vitrine {
namespace {

constexpr int kHeight = 64;
constexpr float kWallTop = 0.3f;  // sine of the elevation up to which photos show the wall
constexpr Vec3f kPaint{0.2f, 0.15f, 0.1f};

// A round wall at a horizontal distance of 2, seen from below the horizon up to kWallTop, but not towards -y.
Surroundings round_wall(float opening = 0.9f) {
  Surroundings s;
  s.height = kHeight;
  const size_t count = 2 * kHeight * kHeight;
  s.distance.assign(count, 0.f);
  s.radiance.assign(count, Vec3f{});
  s.wall.assign(count, false);
  for (size_t t = 0; t < count; ++t) {
    const Vec3f d = s.direction(t);
    if (d.z > kWallTop || d.z < -0.5f || d.y < -opening) continue;
    s.distance[t] = 2 / std::hypot(d.x, d.y);
    s.radiance[t] = kPaint;
    s.wall[t] = true;
  }
  return s;
}

// Dark up to `dark_to`, then sky.
std::vector<Vec3f> light_above(const LightGrid& grid, float dark_to) {
  std::vector<Vec3f> light(grid.cells());
  for (size_t j = 0; j < light.size(); ++j)
    if (grid.direction(j, 0.5f, 0.5f).z > dark_to) light[j] = {1, 1, 1};
  return light;
}

TEST(WallExtension, GoOnUpToTheLight) {
  const LightGrid grid;
  const Surroundings seen = round_wall();
  const ExtendedWalls walls = extended_walls(seen, grid, light_above(grid, 0.625f), std::vector<bool>(grid.cells(), true));
  EXPECT_FLOAT_EQ(walls.sine, 0.625f);
  size_t added = 0;
  for (size_t t = 0; t < seen.wall.size(); ++t) {
    const Vec3f d = seen.direction(t);
    if (walls.source[t] == t) {
      EXPECT_EQ(walls.around.distance[t], seen.distance[t]);
      continue;
    }
    ++added;
    EXPECT_LE(d.z, 0.625f);
    EXPECT_GT(d.z, kWallTop);
    EXPECT_NEAR(walls.around.distance[t] * std::hypot(d.x, d.y), 2, 1e-4);
    EXPECT_TRUE(walls.around.wall[t] && seen.wall[walls.source[t]]);
    EXPECT_EQ(walls.around.radiance[t], kPaint);
  }
  EXPECT_GT(added, 500u);
  // Where the room is open nothing was seen, and nothing is added.
  EXPECT_FALSE(walls.around.wall[seen.texel_of(normalized(Vec3f{0, -1, 0.4f}))]);
  EXPECT_TRUE(walls.around.wall[seen.texel_of(normalized(Vec3f{0, 1, 0.4f}))]);
}

TEST(WallExtension, EndWhereAMirrorShowsTheSky) {
  const LightGrid grid;
  const Surroundings seen = round_wall();
  const std::vector<bool> all(grid.cells(), true);
  const ExtendedWalls walls = extended_walls(seen, grid, light_above(grid, 0.625f), all, 0.45f);
  EXPECT_FLOAT_EQ(walls.sine, 0.45f);
  EXPECT_TRUE(walls.around.wall[seen.texel_of(normalized(Vec3f{0, 1, 0.4f}))]);
  EXPECT_FALSE(walls.around.wall[seen.texel_of(normalized(Vec3f{0, 1, 0.6f}))]);
  EXPECT_FLOAT_EQ(extended_walls(seen, grid, light_above(grid, 0.625f), all, 0.9f).sine, 0.625f)
      << "no higher than the light says";
}

TEST(WallExtension, StopAtLightSkyAndUnknownDirections) {
  const LightGrid grid;
  const auto untouched = [](const ExtendedWalls& walls, const Surroundings& seen) { return walls.around.wall == seen.wall; };
  Surroundings seen = round_wall();
  const std::vector<bool> all(grid.cells(), true), none(grid.cells(), false);
  EXPECT_TRUE(untouched(extended_walls(seen, grid, light_above(grid, 0.f), all), seen)) << "sky right above the wall";
  EXPECT_TRUE(untouched(extended_walls(seen, grid, light_above(grid, 0.625f), none), seen)) << "no cell was solved for";
  const Surroundings half = round_wall(0.f);
  EXPECT_TRUE(untouched(extended_walls(half, grid, light_above(grid, 0.625f), all), half)) << "half of the room is open";
  // Photos show sky above the wall.
  for (size_t t = 0; t < seen.wall.size(); ++t)
    if (!seen.wall[t] && seen.direction(t).z > kWallTop) seen.distance[t] = 50;
  EXPECT_TRUE(untouched(extended_walls(seen, grid, light_above(grid, 0.625f), all), seen)) << "sky is seen";
}

}  // namespace
}  // namespace vitrine
