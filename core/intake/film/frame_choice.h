// Choice of the frames of films that become photos: the sharpest frame of each stretch of motion.
#pragma once

#include <span>
#include <vector>

#include "core/intake/film/film_track.h"

namespace vitrine {

struct ChosenFrame {
  size_t film = 0, frame = 0;  // indices
  size_t among = 1;            // number of frames of its stretch, of which it is the sharpest
};

struct FrameChoice {
  std::vector<ChosenFrame> frames;  // by film, then time
  double least_motion = 0;          // between neighbours, in widths of the longest side
  std::vector<size_t> soft;         // [films] left out: the sharpest frame of its stretch, but blurred against its neighbours
};

// Two neighbours of a film are at least `least_motion` apart: 3 % of the longest side, more if there would be more than `most`
// frames in all. A camera that stands still gives one frame.
FrameChoice choose_frames(std::span<const std::vector<TrackedFrame>> films, size_t most);

}  // namespace vitrine
