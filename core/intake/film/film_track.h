// Sharpness and motion of every frame of a film, from small grey frames. Pure functions of the pixels, in integers: the same on
// every machine and for any number of threads.
//
// Sharpness compares the energy of the gradients with that after one more smoothing, per direction (Crete et al. 2007, "The blur
// effect"): a blurred frame loses little. Motion is the median displacement of textured blocks from an anchor frame, by block
// matching with zero-mean absolute differences; the anchor moves on when the displacement is large enough, so that noise and the
// shaking of a camera on a tripod do not add up.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/intake/film/film_decoder.h"

namespace vitrine {

struct TrackedFrame {
  FrameTime time;
  double sharpness = 0;  // 0 = nothing is lost by smoothing; comparable between frames of the same content
  double motion = 0;     // path of the picture since the first frame, in widths of the longest side; never decreases
};

struct GreySize {
  int width = 0, height = 0;
};
// Size of the grey frames for an upright film of this size: the longest side has at most 640 pixels.
GreySize grey_size(int width, int height);

class FilmTracker {
 public:
  explicit FilmTracker(GreySize size);
  // `grey`: [h * w]. The time is filled in later.
  TrackedFrame next(std::span<const uint8_t> grey);

 private:
  struct Small {
    int width = 0, height = 0;
    std::vector<uint8_t> v;
    double mean = 0;
  };
  Small reduced(std::span<const uint8_t> grey) const;
  double displacement(const Small& from, const Small& to) const;  // pixels of the reduced frames

  GreySize size_;
  Small anchor_;
  double travelled_ = 0, farthest_ = 0;  // pixels of the reduced frames
};

// Of one grey frame.
double sharpness_of(std::span<const uint8_t> grey, GreySize size);

// Decodes the film once. Throws as decode_frames.
std::vector<TrackedFrame> track_film(const FilmInfo& film, const std::function<void(double)>& progress, std::string& warnings);

}  // namespace vitrine
