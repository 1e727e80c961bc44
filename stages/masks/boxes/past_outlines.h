// Outlines of marked things by what the photos show behind them (core/stereo/background.h).
#pragma once

#include "core/stereo/background.h"
#include "core/stereo/small_stereo.h"

namespace vitrine {

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
