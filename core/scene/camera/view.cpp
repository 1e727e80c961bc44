#include "core/scene/camera/view.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

// Smallest eigenvalue of a symmetric 3x3 matrix (trigonometric solution of the characteristic cubic).
double least_eigenvalue(const Mat3d& a) {
  const double mean = (a(0, 0) + a(1, 1) + a(2, 2)) / 3;
  Mat3d b = a;
  double squares = 0;
  for (size_t i = 0; i < 3; ++i) b(i, i) -= mean;
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) squares += b(i, j) * b(i, j);
  const double p = std::sqrt(squares / 6);
  if (!(p > 0)) return mean;
  const double r = std::clamp(determinant(b) / (2 * p * p * p), -1.0, 1.0);
  return mean + 2 * p * std::cos(std::acos(r) / 3 + 2 * M_PI / 3);
}

}  // namespace

LookedAt looked_at(std::span<const View> views) {
  VITRINE_CHECK(!views.empty(), "no cameras");
  Mat3d a{};
  Vec3d b{}, centre{};
  const double share = 1.0 / static_cast<double>(views.size());
  for (const View& v : views) {
    const Vec3d d = transposed_times(v.cam_from_world.rotation, Vec3d{0, 0, 1}), c = v.centre_in_world();
    centre += share * c;
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j) {
        const double m = share * ((i == j ? 1.0 : 0.0) - d[i] * d[j]);
        a(i, j) += m;
        b[i] += m * c[j];
      }
  }
  LookedAt out{.point = centre, .spread = std::max(0.0, least_eigenvalue(a))};
  const double det = determinant(a);
  if (!(det > 0)) return out;
  for (size_t i = 0; i < 3; ++i) {  // Cramer's rule
    Mat3d replaced = a;
    replaced.column(i) = b;
    out.point[i] = determinant(replaced) / det;
  }
  return out;
}

}  // namespace vitrine
