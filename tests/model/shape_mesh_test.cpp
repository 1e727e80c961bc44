// What stands out of turned solids, as a mesh that learns: its slopes against differences, and whether it finds a surface.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rng.h"
#include "core/model/shape_mesh.h"
#include "core/train/mesh_training.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

// A bumpy sheet of triangles; seen from +z.
TriMesh sheet(int side, double bump) {
  TriMesh m;
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) {
      const double x = double(i) / side - 0.5, y = double(j) / side - 0.5;
      m.positions.push_back(cast<float>(Vec3d{x + 0.1 * y, y, bump * std::sin(5 * x + 1) * std::cos(4 * y)}));
    }
  for (uint32_t j = 0; j < uint32_t(side); ++j)
    for (uint32_t i = 0; i < uint32_t(side); ++i) {
      const uint32_t w = uint32_t(side) + 1, a = j * w + i;
      m.faces.push_back({a, a + 1, a + w});
      m.faces.push_back({a + 1, a + w + 1, a + w});
    }
  return m;
}

TEST(MeshSlopes, MatchDifferences) {
  const ShapeMesh mesh(sheet(8, 0.1), 0.1f);
  const MeshSlopes slopes(mesh.mesh());
  Rng rng(4, 1);
  std::vector<double> grad(mesh.mesh().positions.size(), 0.0);
  struct Asked {
    Vec3f eye, direction;
    Vec3d on_normal, on_place;
  };
  std::vector<Asked> rays;
  const auto unit = [&] { return 2 * rng.uniform_double() - 1; };
  for (int k = 0; k < 40; ++k) {
    Asked a{cast<float>(Vec3d{0.3 * unit(), 0.3 * unit(), 2}), {}, {unit(), unit(), unit()}, {unit(), unit(), unit()}};
    a.direction = cast<float>(Vec3d{0.3 * unit(), 0.3 * unit(), 0} - cast<double>(a.eye));
    rays.push_back(a);
  }
  const auto value = [&](const ShapeMesh& m) {
    double sum = 0;
    for (const Asked& a : rays) {
      const auto e = m.entry(a.eye, a.direction);
      sum += dot(a.on_normal, cast<double>(e->normal)) + dot(a.on_place, cast<double>(a.eye + e->t * a.direction));
    }
    return sum;
  };
  for (const Asked& a : rays) {
    const auto e = mesh.entry(a.eye, a.direction);
    ASSERT_TRUE(e);
    const Vec3d n = cast<double>(e->normal), d = cast<double>(a.direction);
    slopes.add(*e, a.on_normal - dot(a.on_normal, n) * n, dot(a.on_place, d) / dot(n, d), grad);
  }
  std::vector<float> exact;
  std::vector<double> differences;
  for (size_t v = 0; v < grad.size(); ++v) {
    const auto moved = [&](float by) {
      TriMesh m = mesh.mesh();
      m.positions[v] += by * m.normals[v];
      return value(ShapeMesh(m, 0.1f));
    };
    exact.push_back(float(grad[v])), differences.push_back((moved(1e-3f) - moved(-1e-3f)) / 2e-3);
  }
  // How the corner angles change along counts for nothing.
  expect_grad_close(exact, differences, {.relative_l2 = 0.12, .bias = 0.05, .row_floor = 0.2}, "vertices");
}

// A flat sheet becomes the bumpy one whose normals it is shown.
TEST(MeshTraining, FindsTheSurfaceWhoseNormalsItIsShown) {
  const ShapeMesh truth(sheet(24, 0.05), 0.1f);
  MeshTraining training(sheet(24, 0), 0.1f);
  Rng rng(5, 1);
  const auto error = [&](bool learn) {
    const MeshSlopes slopes(training.shape()->mesh());
    std::vector<double> grad(training.shape()->mesh().positions.size(), 0.0);
    double angle = 0;
    constexpr int kRays = 400;
    for (int k = 0; k < kRays; ++k) {
      const Vec3f eye{float(0.7 * (rng.uniform_double() - 0.5)), float(0.7 * (rng.uniform_double() - 0.5)), 1}, down{0, 0, -1};
      const auto is = training.shape()->entry(eye, down), should = truth.entry(eye, down);
      if (!is || !should) continue;
      const Vec3d n = cast<double>(is->normal), off = n - cast<double>(should->normal);
      slopes.add(*is, off - dot(off, n) * n, 0, grad);
      angle += length(off) / kRays;
    }
    if (learn) training.descend(grad, 1e-3);
    return angle;
  };
  const double before = error(false);
  ASSERT_GT(before, 0.05);
  for (int step = 0; step < 200; ++step) error(true);
  EXPECT_LT(error(false), 0.3 * before);
  // A killed run goes on alike; broken gradients move nothing.
  ArchiveWriter out;
  training.save(out);
  ArchiveReader in(out.bytes());
  MeshTraining resumed;
  resumed.load(in);
  EXPECT_TRUE(in.at_end());
  std::vector<double> grad(training.shape()->mesh().positions.size(), 0.0);
  grad[100] = 1;
  for (MeshTraining* t : {&training, &resumed}) t->descend(grad, 1e-3);
  EXPECT_EQ(training.shape()->mesh().positions, resumed.shape()->mesh().positions);
  const auto positions = training.shape()->mesh().positions;
  grad[3] = NAN;
  training.descend(grad, 1);
  training.descend({}, 1);
  EXPECT_EQ(training.shape()->mesh().positions, positions);
  MeshTraining none;
  none.descend({}, 1);
  EXPECT_EQ(none.shape(), nullptr);
}

}  // namespace
}  // namespace vitrine
