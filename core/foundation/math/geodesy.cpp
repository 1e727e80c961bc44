#include "core/foundation/math/geodesy.h"

#include <cmath>
#include <numbers>

namespace vitrine {

namespace {

constexpr double kSemiMajor = 6378137.0, kFlattening = 1 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);
constexpr double kDegree = std::numbers::pi / 180;

// Radius of curvature in the prime vertical.
double prime_vertical(double sin_latitude) { return kSemiMajor / std::sqrt(1 - kEccentricity2 * sin_latitude * sin_latitude); }

}  // namespace

Vec3d earth_centred(const Geodetic& place) {
  const double phi = place.latitude * kDegree, lambda = place.longitude * kDegree;
  const double n = prime_vertical(std::sin(phi)), h = place.altitude;
  return {(n + h) * std::cos(phi) * std::cos(lambda), (n + h) * std::cos(phi) * std::sin(lambda),
          (n * (1 - kEccentricity2) + h) * std::sin(phi)};
}

Geodetic geodetic(const Vec3d& p) {
  const double across = std::hypot(p.x, p.y);
  double phi = std::atan2(p.z, across * (1 - kEccentricity2));
  constexpr int kRounds = 12;  // each reduces the error by the square of the eccentricity, 0.0067, or more
  for (int i = 0; i < kRounds; ++i) {
    const double s = std::sin(phi);
    phi = std::atan2(p.z + kEccentricity2 * prime_vertical(s) * s, across);
  }
  const double s = std::sin(phi), c = std::cos(phi);
  // Distance along the normal: regular at the equator and at the poles.
  const double h = across * c + p.z * s - kSemiMajor * std::sqrt(1 - kEccentricity2 * s * s);
  return {phi / kDegree, std::atan2(p.y, p.x) / kDegree, h};
}

LocalFrame::LocalFrame(const Geodetic& origin) : origin_(origin) {
  const double phi = origin.latitude * kDegree, lambda = origin.longitude * kDegree;
  const double sp = std::sin(phi), cp = std::cos(phi), sl = std::sin(lambda), cl = std::cos(lambda);
  earth_from_local_ = {Mat3d{Vec3d{-sl, cl, 0}, Vec3d{-sp * cl, -sp * sl, cp}, Vec3d{cp * cl, cp * sl, sp}},
                       earth_centred(origin)};
}

Vec3d LocalFrame::local(const Geodetic& place) const { return inverse(earth_from_local_) * earth_centred(place); }

Geodetic LocalFrame::place(const Vec3d& local) const { return geodetic(earth_from_local_ * local); }

}  // namespace vitrine
