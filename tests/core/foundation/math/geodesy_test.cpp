// Geodetic conversions against published values: IOGP Guidance Note 7-2, examples of the methods 9602 and 9837.
#include "core/foundation/math/geodesy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/rng.h"

namespace vitrine {
namespace {

constexpr double kSemiMinor = 6356752.314245;  // NIMA TR8350.2

double of_angle(int degrees, int minutes, double seconds) { return degrees + minutes / 60.0 + seconds / 3600; }
const Geodetic kNorthSea{of_angle(53, 48, 33.820), of_angle(2, 7, 46.380), 73};

void expect_near(const Vec3d& found, const Vec3d& expected, double tolerance) {
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], tolerance) << "component " << c;
}

TEST(Geodesy, EarthCentredCoordinatesArePublishedOnes) {
  expect_near(earth_centred({0, 0, 0}), {6378137, 0, 0}, 1e-9);
  expect_near(earth_centred({0, 90, 10}), {0, 6378147, 0}, 1e-9);
  expect_near(earth_centred({90, 0, 0}), {0, 0, kSemiMinor}, 1e-6);
  expect_near(earth_centred({-90, 0, 0}), {0, 0, -kSemiMinor}, 1e-6);
  expect_near(earth_centred(kNorthSea), {3771793.968, 140253.342, 5124304.349}, 1e-3);
}

TEST(Geodesy, TheInverseIsPublishedToo) {
  const Geodetic g = geodetic({3771793.968, 140253.342, 5124304.349});
  EXPECT_NEAR(g.latitude, kNorthSea.latitude, 1e-8);
  EXPECT_NEAR(g.longitude, kNorthSea.longitude, 1e-8);
  EXPECT_NEAR(g.altitude, 73, 1e-3);
}

TEST(Geodesy, LocalFrameIsEastNorthUp) {
  const LocalFrame frame({55, 5, 200});
  expect_near(frame.local(kNorthSea), {-189013.869, -128642.040, -4220.171}, 1e-3);
  // A metre on the ellipsoid, by its radii of curvature at this latitude.
  expect_near(frame.local({55 + 1 / 111327.0, 5, 200}), {0, 1, 0}, 1e-4);
  expect_near(frame.local({55, 5 + 1 / 63996.1, 200}), {1, 0, 0}, 1e-4);
  expect_near(frame.local({55, 5, 203}), {0, 0, 3}, 1e-8);
}

TEST(Geodesy, RoundTripsEverywhere) {
  std::vector<Geodetic> places{{90, 0, 5}, {-90, 0, -5}, {0, 180, 0}, {0, -179.9999999, 100}, {1e-12, 0, 0}, {89.9999999, 77, 3}};
  for (uint64_t i = 0; i < 500; ++i) {
    Rng rng(3, i);
    const double latitude = 180 * rng.uniform_double() - 90, longitude = 360 * rng.uniform_double() - 180;
    places.push_back({latitude, longitude, -12000 + 32000 * rng.uniform_double()});
  }
  for (const Geodetic& p : places) {
    expect_near(earth_centred(geodetic(earth_centred(p))), earth_centred(p), 1e-6);
    EXPECT_NEAR(geodetic(earth_centred(p)).latitude, p.latitude, 1e-10);
    EXPECT_NEAR(geodetic(earth_centred(p)).altitude, p.altitude, 1e-6);
    const LocalFrame frame({p.latitude, p.longitude, 0});
    const Vec3d at{120, -80, 15};
    expect_near(frame.local(frame.place(at)), at, 1e-6);
  }
}

}  // namespace
}  // namespace vitrine
