// Places on the ellipsoid WGS84 (NIMA TR8350.2) and local frames: x = east, y = north, z = up, in metres.
#pragma once

#include "core/foundation/math/rigid.h"

namespace vitrine {

struct Geodetic {
  double latitude = 0, longitude = 0;  // degrees, north and east positive
  double altitude = 0;                 // metres above the ellipsoid
};

// Earth-centred coordinates in metres: x through latitude and longitude zero, z through the north pole.
Vec3d earth_centred(const Geodetic& place);
// Inverse, by fixed-point iteration on the latitude; altitudes from -12 to 20 km to a micrometre.
Geodetic geodetic(const Vec3d& earth_centred);

// Local frame around a place.
class LocalFrame {
 public:
  explicit LocalFrame(const Geodetic& origin);
  Vec3d local(const Geodetic& place) const;  // east, north, up in metres
  Geodetic place(const Vec3d& local) const;
  const Geodetic& origin() const { return origin_; }

 private:
  Geodetic origin_;
  Rigid earth_from_local_;
};

}  // namespace vitrine
