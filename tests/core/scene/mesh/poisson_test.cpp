#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/mesh/mesh_distance.h"
#include "core/scene/mesh/poisson_cgal.h"
#include "core/scene/mesh/repair_cgal.h"
#include "tests/core/scene/mesh/shapes.h"

namespace vitrine {
namespace {

struct Samples {
  std::vector<Vec3f> points, normals;
};

// Noise along the normal; `kept` leaves parts out.
Samples samples_of(const TriMesh& mesh, size_t count, double noise, const std::function<bool(const Vec3f&)>& kept) {
  const SurfaceSamples all = sample_surface(mesh, count, 3);
  Samples out;
  Rng rng(5);
  for (size_t i = 0; i < count; ++i) {
    const Vec3f moved = all.positions[i] + float(noise * rng.normal()) * all.normals[i];
    if (!kept(all.positions[i])) continue;
    out.points.push_back(moved);
    out.normals.push_back(all.normals[i]);
  }
  return out;
}

double mean_distance(const TriMesh& from, const TriMesh& to) {
  double sum = 0;
  const std::vector<float> distances = MeshDistance(to).distances(sample_surface(from, 5000, 7).positions);
  for (float d : distances) sum += d;
  return sum / double(distances.size());
}

void expect_one_solid(const TriMesh& mesh) {
  const MeshReport r = mesh_report(mesh);
  EXPECT_TRUE(r.closed());
  EXPECT_EQ(r.manifold_edges, r.edges);
  EXPECT_EQ(r.components, 1u);
  EXPECT_EQ(r.euler, 2);
  EXPECT_EQ(r.degenerate_faces, 0u);
}

TEST(Poisson, ClosesASphereWithAHoleInItsSamples) {
  const TriMesh sphere = shapes::sphere({1, 2, 3}, 1, 40, 60);
  const Samples s = samples_of(sphere, 2500, 0.01, [](const Vec3f& p) { return p.z < 3.85f; });  // a cap of 32 degrees is missing
  PoissonReport report;
  const TriMesh mesh = poisson_surface(s.points, s.normals, &report);
  expect_one_solid(mesh);
  EXPECT_FALSE(report.inwards);
  EXPECT_EQ(report.points, s.points.size());
  EXPECT_NEAR(mesh_report(mesh).volume, mesh_report(sphere).volume, 0.04 * mesh_report(sphere).volume);
  EXPECT_LT(mean_distance(mesh, sphere), 0.02);
  EXPECT_LT(mean_distance(sphere, mesh), 0.02);
}

TEST(Poisson, ClosesABoxThatStandsOnATable) {
  const TriMesh box = shapes::cube();
  const Samples s = samples_of(box, 2500, 0.004, [](const Vec3f& p) { return p.z > 0.001f; });  // without its lower side
  const TriMesh mesh = poisson_surface(s.points, s.normals);
  expect_one_solid(mesh);
  EXPECT_NEAR(mesh_report(mesh).volume, 1, 0.18);  // it bulges where nothing was sampled
  EXPECT_LT(mean_distance(box, mesh), 0.03);
}

TEST(Poisson, FacesLookWhereTheNormalsPoint) {
  const TriMesh sphere = shapes::sphere({0, 0, 0}, 1, 40, 60);
  Samples s = samples_of(sphere, 1500, 0, [](const Vec3f&) { return true; });
  for (Vec3f& n : s.normals) n = -n;
  PoissonReport report;
  const TriMesh mesh = poisson_surface(s.points, s.normals, &report);
  expect_one_solid(mesh);
  EXPECT_TRUE(report.inwards);
  EXPECT_LT(mesh_report(mesh).volume, -4);
}

TEST(Poisson, KeepsTwoObjectsApart) {
  TriMesh two = shapes::sphere({0, 0, 0}, 1, 30, 40);
  shapes::append(two, shapes::sphere({3, 0, 0}, 0.5f, 20, 30));
  const Samples s = samples_of(two, 2500, 0, [](const Vec3f&) { return true; });
  const MeshReport r = mesh_report(poisson_surface(s.points, s.normals));
  EXPECT_TRUE(r.closed());
  EXPECT_EQ(r.components, 2u);
  EXPECT_NEAR(r.volume, mesh_report(two).volume, 0.06 * mesh_report(two).volume);
}

// A ball above an open table: nothing below the table was sampled.
TEST(Poisson, EndsAnOpenSceneAtItsBox) {
  TriMesh scene = shapes::grid(8);
  shapes::append(scene, shapes::sphere({0.5f, 0.5f, 0.25f}, 0.15f, 20, 30));
  const Samples s = samples_of(scene, 3000, 0, [](const Vec3f&) { return true; });
  PoissonReport report;
  const TriMesh mesh = poisson_surface(s.points, s.normals, &report);
  const MeshReport r = mesh_report(mesh);
  EXPECT_TRUE(r.closed());
  EXPECT_GT(report.cut_points, 100u);
  EXPECT_FALSE(report.inwards);
  EXPECT_LT(mean_distance(scene, mesh), 0.01);
  EXPECT_GT(r.volume, 0);
  const double margin = 0.1;  // a twentieth of the diagonal, and what the surface bulges
  EXPECT_GT(r.bounds.low.z, -margin);
  EXPECT_GT(r.bounds.low.x, -margin);
  EXPECT_LT(r.bounds.high.y, 1 + margin);
}

std::string code_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& e) {
    return e.detail().code;
  }
  return "";
}

TEST(Poisson, RefusesTooFewPointsAndPointsOfOnePlane) {
  EXPECT_EQ(code_of([] { poisson_surface({}, {}); }), "NOT_CLOSED");
  Samples s = samples_of(shapes::sphere({0, 0, 0}, 1, 20, 30), 300, 0, [](const Vec3f&) { return true; });
  EXPECT_THROW(poisson_surface(s.points, std::span(s.normals).first(299)), Error);
  std::fill(s.normals.begin() + 50, s.normals.end(), Vec3f{});  // 50 are left
  EXPECT_EQ(code_of([&] { poisson_surface(s.points, s.normals); }), "NOT_CLOSED");
  s = samples_of(shapes::grid(4), 300, 0, [](const Vec3f&) { return true; });
  EXPECT_EQ(code_of([&] { poisson_surface(s.points, s.normals); }), "NOT_CLOSED");
  std::fill(s.points.begin(), s.points.end(), Vec3f{1, 1, 1});
  EXPECT_EQ(code_of([&] { poisson_surface(s.points, s.normals); }), "NOT_CLOSED");
}

TEST(Poisson, DoesNotDependOnThreadsAndCanBeInterrupted) {
  const Samples s = samples_of(shapes::sphere({0, 0, 0}, 1, 30, 40), 1500, 0.01, [](const Vec3f&) { return true; });
  std::vector<TriMesh> meshes;
  for (int threads : {1, 4}) {
    set_thread_limit(threads);
    meshes.push_back(poisson_surface(s.points, s.normals));
  }
  set_thread_limit(0);
  EXPECT_EQ(meshes[0].positions, meshes[1].positions);
  EXPECT_EQ(meshes[0].faces, meshes[1].faces);
  struct Stop {};
  EXPECT_THROW(poisson_surface(s.points, s.normals, nullptr, [](double) { throw Stop{}; }), Stop);
}

}  // namespace
}  // namespace vitrine
