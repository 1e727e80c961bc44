// Where the cameras of a reconstruction stand around what they look at, and where more photos would help. Frame of the scene:
// +z up, azimuth counter-clockwise from +x seen from above (core/conventions.md).
#pragma once

#include <string>
#include <vector>

#include "core/camera/view_set.h"

namespace vitrine {

struct RingGap {
  double from_deg = 0, to_deg = 0;  // azimuths in [0, 360) of the photos at its ends, counter-clockwise
  std::string from, to;             // their names
  size_t photos_to_add = 0;         // to come down to steps of kRingStep
  double width_deg() const;
};
inline constexpr double kRingStepDeg = 15;

struct Coverage {
  size_t cameras = 0;
  bool inward = false;                     // the cameras look at one place; else a walk, or views outwards: no ring to close
  Vec3d centre;                            // nearest to all viewing axes
  std::vector<RingGap> gaps;               // widest first, all above twice the step
  double lowest_deg = 0, highest_deg = 0;  // elevation of cameras above the centre
  double thin_points = 0;                  // share of scene points seen by two photos only
};

Coverage coverage(const ViewSet& views);

}  // namespace vitrine
