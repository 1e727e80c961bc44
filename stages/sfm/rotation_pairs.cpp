#include "stages/sfm/rotation_pairs.h"

#include <algorithm>
#include <cmath>

#include "core/math/vec.h"

namespace vitrine {

namespace {

constexpr double kRotationSlack = 0.06;  // of the entries of R^T R - I, root of the sum of squares; noise of a few pixels
constexpr double kTurnDeg = 1;           // less is no turn

// How far K^-1 H K, scaled to determinant 1, is from a rotation; `turn_deg` is its angle.
double off_rotation(const std::vector<double>& h, double focal, double cx, double cy, double& turn_deg) {
  const auto column = [&](size_t c) { return Vec3d{h[c], h[3 + c], h[6 + c]}; };
  const Mat3d k{{focal, 0, 0}, {0, focal, 0}, {cx, cy, 1}};
  const Mat3d inverse{{1 / focal, 0, 0}, {0, 1 / focal, 0}, {-cx / focal, -cy / focal, 1}};
  Mat3d r = inverse * Mat3d{column(0), column(1), column(2)} * k;
  const double scale = std::cbrt(determinant(r));
  if (!(std::abs(scale) > 0)) return 1e9;
  r = {r.c0 / scale, r.c1 / scale, r.c2 / scale};
  const Mat3d s = transposed(r) * r;
  double sum = 0;
  for (const Vec3d& e : {s.c0 - Vec3d{1, 0, 0}, s.c1 - Vec3d{0, 1, 0}, s.c2 - Vec3d{0, 0, 1}}) sum += dot(e, e);
  constexpr double kDegree = 57.29577951308232;
  turn_deg = std::acos(std::clamp((r.c0.x + r.c1.y + r.c2.z - 1) / 2, -1.0, 1.0)) * kDegree;
  return std::sqrt(sum);
}

}  // namespace

double rotation_share(std::span<const VerifiedPair> pairs, int width, int height) {
  if (pairs.empty()) return 0;
  const double longest = std::max(width, height);
  size_t best = 0;
  constexpr double kWidest = 0.4, kNarrowest = 6, kStep = 1.1;  // focal lengths over the longest side
  for (double f = kWidest; f < kNarrowest; f *= kStep) {
    size_t explained = 0;
    for (const VerifiedPair& p : pairs) {
      if (p.config < kFirstPlanarPair || p.config > kLastPlanarPair || p.homography.empty()) continue;
      double turn = 0;
      const double off = off_rotation(p.homography, f * longest, 0.5 * width, 0.5 * height, turn);
      explained += off < kRotationSlack && turn > kTurnDeg;
    }
    best = std::max(best, explained);
  }
  return double(best) / double(pairs.size());
}

}  // namespace vitrine
