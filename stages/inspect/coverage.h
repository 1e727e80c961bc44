// Camera positions around the object of a reconstruction, and gaps where more photos would help. Scene frame: +z up, azimuth
// counter-clockwise from +x seen from above (core/conventions.md).
#pragma once

#include <string>
#include <vector>

#include "core/scene/camera/view_set.h"

namespace vitrine {

struct RingGap {
  double from_deg = 0, to_deg = 0;  // azimuths in [0, 360) of the photos at the ends of the gap, counter-clockwise
  std::string from, to;             // names of these photos
  size_t photos_to_add = 0;         // to reduce the steps to kRingStep
  double width_deg() const;
};
inline constexpr double kRingStepDeg = 15;

struct Coverage {
  size_t cameras = 0;
  bool inward = false;                     // the cameras look at one point; false for walks and outward views, which form no ring
  Vec3d centre;                            // point closest to all viewing axes
  std::vector<RingGap> gaps;               // widest first; only gaps above twice the step
  double lowest_deg = 0, highest_deg = 0;  // elevation of cameras above the centre
  double thin_points = 0;                  // fraction of scene points seen by two photos only
};

Coverage coverage(const ViewSet& views);

}  // namespace vitrine
