#include "core/scene/mesh/tsdf_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_distance.h"
#include "core/scene/mesh/tri_mesh.h"
#include "tests/core/scene/mesh/orbit.h"

namespace vitrine {
namespace {

using Scene = std::function<std::optional<orbit::Hit>(const Vec3d&, const Vec3d&)>;

TsdfVolume fused(const std::vector<orbit::Map>& maps, const TsdfDesc& desc) {
  TsdfVolume volume(desc);
  for (const auto& m : maps) volume.touch(m.view());
  volume.allocate();
  for (const auto& m : maps) volume.integrate(m.view());
  return volume;
}
std::vector<orbit::Map> maps_of(const std::vector<View>& views, const Scene& scene) {
  std::vector<orbit::Map> maps;
  for (const View& v : views) maps.push_back(orbit::map(v, scene));
  return maps;
}
const Bounds3 kBox{{-0.6, -0.6, -0.6}, {0.6, 0.6, 0.6}};
constexpr double kVoxel = 1.2 / 64;

Scene sphere(double radius) {
  return [=](const Vec3d& o, const Vec3d& d) { return orbit::hit_sphere({0, 0, 0}, radius, o, d); };
}

TEST(Tsdf, RebuildsASphereWatertightWithinHalfAVoxel) {
  const auto maps = maps_of(orbit::views(8, {-60, -20, 20, 60}, 1.5, 160), sphere(0.4));
  const TriMesh mesh = iso_surface(fused(maps, {.bounds = kBox, .voxel = kVoxel}));
  const MeshReport r = mesh_report(mesh);
  EXPECT_TRUE(r.closed());
  EXPECT_EQ(r.components, 1u);
  EXPECT_EQ(r.euler, 2);
  const SurfaceSamples samples = sample_surface(mesh, 20000, 1);
  double accuracy = 0, worst = 0;
  for (const Vec3f& p : samples.positions) {
    const double error = std::abs(double(length(p)) - 0.4);
    accuracy += error / 20000;
    worst = std::max(worst, error);
  }
  EXPECT_LT(accuracy, 0.1 * kVoxel);  // seen: 0.03
  EXPECT_LT(worst, 0.5 * kVoxel);
  const MeshDistance distance(mesh);
  Rng rng(9);
  double completeness = 0;
  for (int i = 0; i < 5000; ++i)
    completeness +=
        distance.closest(cast<float>(0.4 * normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()}))).distance / 5000;
  EXPECT_LT(accuracy + completeness, 0.5 * kVoxel);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3f n = normalized(mesh.positions[v]);
    EXPECT_GT(dot(mesh.normals[v], n), 0.98f);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(mesh.colors[v][c], 0.5f + 0.5f * n[c], 0.12f);  // painted by its normal
  }
}

TEST(Tsdf, AveragesNoiseOfManyViews) {
  auto maps = maps_of(orbit::views(8, {-60, -20, 20, 60}, 1.5, 160), sphere(0.4));
  Rng rng(3);
  for (auto& m : maps)
    for (float& z : m.zdepth) z += 0.7f * float(kVoxel) * rng.normal() * (z > 0);
  const TriMesh mesh = iso_surface(fused(maps, {.bounds = kBox, .voxel = kVoxel}));
  double error = 0;
  for (const Vec3f& p : mesh.positions) error += std::abs(double(length(p)) - 0.4) / double(mesh.positions.size());
  EXPECT_LT(error, 0.25 * kVoxel);  // a single view: 0.56
}

TEST(Tsdf, RebuildsAPlaneExactly) {
  const auto views = orbit::views(6, {40, 70}, 1.5, 160);
  const TriMesh mesh =
      iso_surface(fused(maps_of(views, [](const Vec3d& o, const Vec3d& d) { return orbit::hit_square(0.1, 0.5, o, d); }),
                        {.bounds = kBox, .voxel = kVoxel}));
  EXPECT_GT(mesh.faces.size(), 3000u);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3f& p = mesh.positions[v];
    if (std::abs(p.x) > 0.4f || std::abs(p.y) > 0.4f) continue;
    EXPECT_NEAR(p.z, 0.1, 0.02 * kVoxel);
    EXPECT_GT(mesh.normals[v].z, 0.99f);
  }
}

// A sheet of two voxels, seen from above and below: the band behind each side must not erase the other side.
TEST(Tsdf, KeepsAThinPlate) {
  const Scene plate = [](const Vec3d& o, const Vec3d& d) {
    return orbit::nearer(orbit::hit_square(kVoxel, 0.4, o, d), orbit::hit_square(-kVoxel, 0.4, o, d));
  };
  const TriMesh mesh =
      iso_surface(fused(maps_of(orbit::views(8, {-60, 60}, 1.5, 200), plate), {.bounds = kBox, .voxel = kVoxel}));
  const MeshDistance distance(mesh);
  for (int i = 0; i < 200; ++i) {
    Rng rng(i);
    const Vec3f p{0.6f * rng.uniform() - 0.3f, 0.6f * rng.uniform() - 0.3f, float((i % 2 ? 1 : -1) * kVoxel)};
    EXPECT_LT(distance.closest(p).distance, 0.8 * kVoxel);
  }
}

TEST(Tsdf, CarvesAFloaterThatOneViewInvented) {
  auto maps = maps_of(orbit::views(8, {-60, -20, 20, 60}, 1.5, 160), sphere(0.3));
  Scene floater = [](const Vec3d& o, const Vec3d& d) { return orbit::hit_sphere({0, 0, 0.45}, 0.05, o, d); };
  const orbit::Map wrong = orbit::map(maps[20].of, floater);
  const auto background = [](orbit::Map& m) {  // what stands behind, far away: free space in front of it
    for (size_t p = 0; p < m.zdepth.size(); ++p)
      if (m.zdepth[p] == 0) {
        m.zdepth[p] = 2.5f;
        m.weight[p] = 0.1f;
      }
  };
  for (auto& m : maps) background(m);
  for (size_t p = 0; p < wrong.zdepth.size(); ++p)
    if (wrong.zdepth[p] > 0 && wrong.zdepth[p] < maps[20].zdepth[p]) {
      maps[20].zdepth[p] = wrong.zdepth[p];
      maps[20].weight[p] = wrong.weight[p];
    }
  const auto highest = [&](double free_space_weight) {
    return mesh_report(iso_surface(fused(maps, {.bounds = kBox, .voxel = kVoxel, .free_space_weight = free_space_weight})))
        .bounds.high.z;
  };
  EXPECT_GT(highest(0), 0.4);
  EXPECT_LT(highest(0.2), 0.32);
}

TEST(Tsdf, DepthEdgesLeaveNoSkirt) {
  const Scene two = [](const Vec3d& o, const Vec3d& d) {
    return orbit::nearer(orbit::hit_sphere({0, 0, 0.25}, 0.2, o, d), orbit::hit_square(-0.45, 0.6, o, d));
  };
  const TriMesh mesh = iso_surface(fused(maps_of(orbit::views(1, {89}, 1.5, 200), two), {.bounds = kBox, .voxel = kVoxel}));
  for (const Vec3f& p : mesh.positions) EXPECT_FALSE(p.z > -0.35f && p.z < 0.15f) << p.x << " " << p.y << " " << p.z;
}

TEST(Tsdf, TwoRoomsAreTwoComponents) {
  const Scene two = [](const Vec3d& o, const Vec3d& d) {
    return orbit::nearer(orbit::hit_sphere({0.3, 0, 0}, 0.2, o, d), orbit::hit_sphere({-0.3, 0, 0}, 0.15, o, d));
  };
  const TriMesh mesh =
      iso_surface(fused(maps_of(orbit::views(8, {-60, -20, 20, 60}, 1.5, 160), two), {.bounds = kBox, .voxel = kVoxel}));
  EXPECT_EQ(mesh_report(without_small_components(mesh, {})).components, 2u);
}

TEST(Tsdf, SameBytesForAnyNumberOfThreads) {
  const auto maps = maps_of(orbit::views(6, {-30, 30}, 1.5, 120), sphere(0.4));
  std::vector<TsdfVolume> volumes;
  for (int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    volumes.push_back(fused(maps, {.bounds = kBox, .voxel = kVoxel}));
  }
  set_thread_limit(0);
  for (size_t k = 1; k < volumes.size(); ++k) {
    ASSERT_EQ(volumes[k].block_count(), volumes[0].block_count());
    for (size_t b = 0; b < volumes[0].block_count(); ++b)
      EXPECT_EQ(std::memcmp(&volumes[k].block(b), &volumes[0].block(b), sizeof(TsdfBlock)), 0);
  }
}

TEST(Tsdf, RefusesAVolumeThatCannotBe) { EXPECT_THROW(TsdfVolume({.bounds = kBox, .voxel = 1e-6}), Error); }

}  // namespace
}  // namespace vitrine
