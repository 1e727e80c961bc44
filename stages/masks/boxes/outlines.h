// Outlines of marked things in the photos, near where a hull is: by colour, or by what the photos show behind the thing.
#pragma once

#include <cstdint>
#include <vector>

#include "core/observe/stereo/background.h"
#include "core/observe/stereo/small_stereo.h"
#include "stages/masks/small_photo.h"

namespace vitrine {

// The outline of a thing that differs in colour from what surrounds it: GrabCut (Rother et al. 2004).
// [h,w] 1 = thing. `about`: the hull's silhouette; `tight`: only near its edge is there a doubt, its middle is the thing whatever
// its colours (those of polished metal are its surroundings'). Empty when the silhouette has next to no pixels, touches
// everything, or what is found has little to do with it.
std::vector<uint8_t> grab_cut(const SmallPhoto& photo, const std::vector<uint8_t>& about, bool tight);

// Outlines of things by what the photos show behind them (core/observe/stereo/background.h).
class PastOutlines {
 public:
  explicit PastOutlines(const SmallStereo& stereo) : stereo_(stereo) {}  // refers to it

  // Of HullDesc.
  std::vector<HalfSpace> sides(const VisualHull& hull) const;
  // [view][h,w] 1 where something stands in front of a hull that surely holds all of the thing.
  std::vector<std::vector<uint8_t>> hidden(const VisualHull& around) const;
  // [view] coverage 0 or 1 of the thing in the hull; negative in `hidden` pixels. Stops early on an interrupt.
  std::vector<Silhouette> outlines(const VisualHull& hull, std::span<const std::vector<uint8_t>> hidden) const;

 private:
  const SmallStereo& stereo_;
};

}  // namespace vitrine
