// What each pixel around the object says about its surroundings: do they stand still with the object, or move against it (the
// room around a turntable)? In the frame of the object, which the poses are relative to:
//   stands still   dense stereo explains the pixel: other photos confirm a surface there
//   moves          the pixel has texture, two neighbours look at its place, and no surface explains it; or it looks the same at
//                  the same place of photos whose cameras look from elsewhere: a room before a camera on a tripod
// A pixel without texture says nothing about itself. A plain backdrop shows in the whole: most of the picture is alike in place.
#pragma once

#include "core/learn/trainer/targets.h"
#include "stages/optimize/dense_depth.h"

namespace vitrine {

enum class Evidence : unsigned char { None, Still, Moves, Object };

// Of one training photo, at the size of its depth map, without single dissenters. Empty: the photo has no depth map.
struct PhotoEvidence {
  int width = 0, height = 0;
  std::vector<Evidence> pixels;  // Object: inside its mask or within a patch of its silhouette
  std::vector<uint8_t> plain;    // 1: without texture and alike in place
  std::vector<uint8_t> fine;     // 1: texture within a pixel; else a patch matches by what lies beside it
};

// Pixels around the object, in all training photos together.
struct EvidenceCounts {
  size_t all = 0;
  size_t still = 0;        // explained
  size_t unexplained = 0;  // has texture, and two neighbours should see it
  size_t in_place = 0;     // has texture and looks the same in place
  size_t plain = 0;        // has none and looks the same in place, in nearly all photos

  double part(size_t n) const;  // of all that say something
  // Surroundings that move, in part at least.
  bool moving() const;
  bool moving_by_texture() const;  // not by a plain backdrop alone
};

struct MovingEvidence {
  std::vector<PhotoEvidence> photos;  // [capture.photos]
  EvidenceCounts counts;
};
MovingEvidence moving_evidence(const Capture& capture, const Targets& targets, const DenseDepth& dense);

}  // namespace vitrine
