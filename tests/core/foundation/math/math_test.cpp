#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/dual.h"
#include "core/foundation/math/rigid.h"
#include "core/foundation/math/spherical_harmonics.h"

namespace vitrine {
namespace {

TEST(Quaternion, RoundTripsThroughTheRotationMatrix) {
  Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const Quatd q = normalized(Quatd{rng.normal(), rng.normal(), rng.normal(), rng.normal()});
    const Mat3d R = rotation_matrix(q);
    EXPECT_NEAR(determinant(R), 1.0, 1e-12);
    const Quatd back = quaternion(R);
    const double same = back.w * q.w + back.x * q.x + back.y * q.y + back.z * q.z;
    EXPECT_NEAR(std::abs(same), 1.0, 1e-12);
  }
}

TEST(Quaternion, VjpMatchesDualNumbersForRawQuaternions) {
  using D = Dual<double, 4>;
  Rng rng(2);
  for (int trial = 0; trial < 50; ++trial) {
    double raw[4];
    for (double& r : raw) r = rng.normal();
    Mat3d G;
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j) G(i, j) = rng.normal();
    const Quat<D> q{D::variable(raw[0], 0), D::variable(raw[1], 1), D::variable(raw[2], 2), D::variable(raw[3], 3)};
    const Mat3<D> R = rotation_matrix(normalized(q));
    D loss(0.0);
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j) loss += D(G(i, j)) * R(i, j);
    const Quatd g = rotation_matrix_vjp(Quatd{raw[0], raw[1], raw[2], raw[3]}, G);
    EXPECT_NEAR(g.w, loss.d[0], 1e-10);
    EXPECT_NEAR(g.x, loss.d[1], 1e-10);
    EXPECT_NEAR(g.y, loss.d[2], 1e-10);
    EXPECT_NEAR(g.z, loss.d[3], 1e-10);
  }
}

TEST(Rigid, InverseUndoesAndWorldMovesCarryCamerasAlong) {
  const Rigid cam_from_world{rotation_matrix(normalized(Quatd{1, 2, 3, 4})), {0.5, -1, 2}};
  const Similarity new_from_old{2.5, rotation_matrix(normalized(Quatd{-1, 0.2, 3, 1})), {3, 2, 1}};
  const Vec3d p{0.3, 0.7, -1.1};
  EXPECT_NEAR(length(inverse(cam_from_world) * (cam_from_world * p) - p), 0, 1e-12);
  EXPECT_NEAR(length(inverse(new_from_old) * (new_from_old * p) - p), 0, 1e-12);
  const Vec3d expected = 2.5 * (cam_from_world * p);
  EXPECT_NEAR(length(transformed_world(cam_from_world, new_from_old) * (new_from_old * p) - expected), 0, 1e-12);
}

TEST(SphericalHarmonics, DirectionGradientMatchesDualNumbersAtEveryDegree) {
  using D = Dual<double, 3>;
  Rng rng(3);
  for (int degree = 0; degree <= 3; ++degree) {
    const Vec3d dir = normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()});
    double weight[16];
    for (double& w : weight) w = rng.normal();
    D basis[16];
    sh_basis<D>(degree, {D::variable(dir.x, 0), D::variable(dir.y, 1), D::variable(dir.z, 2)}, basis);
    D loss(0.0);
    for (size_t k = 0; k < sh_coefficient_count(degree); ++k) loss += D(weight[k]) * basis[k];
    const Vec3d g = sh_basis_vjp(degree, dir, weight);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(g[i], loss.d[i], 1e-6);  // constants are given to float precision
  }
}

}  // namespace
}  // namespace vitrine
