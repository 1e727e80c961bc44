// One marked thing, carried from its few marks to all photos (marked_source.h says how).
#pragma once

#include <optional>

#include "core/observe/stereo/small_stereo.h"
#include "stages/masks/boxes/marks_file.h"
#include "stages/masks/small_photo.h"

namespace vitrine {

inline constexpr int kHullVoxels = 96;  // along the longest side of a marked thing

struct CarryDesc {
  const MaskCapture& capture;
  const std::vector<View>& views;         // of the capture, at the small size
  const std::vector<SmallPhoto>& photos;  // the same with their colours; may be empty where all things are glass
  const SmallStereo* stereo = nullptr;    // looks past the hulls of mirrors in boxes
  int hull_voxels = kHullVoxels;
};

struct CarriedThing {
  struct Summary {
    std::string name, word;  // MarkedThing
    MaskClass kind;
    size_t marks = 0, refined = 0;  // photos marked; photos whose outline was found (no polygon says it)
    double edge = 0;                // longest edge of the hull's box, scene units
    bool voted = false;             // the second hull gave the masks
    size_t solids = 0;              // of revolution, found in it
    double box_agreement = 0;       // with a box that was taken for it; 0 = none
  };
  std::vector<std::vector<uint8_t>> inside, doubted;  // [view][h,w]; doubted: outline and hull disagree
  VisualHull hull;
  std::vector<HullDepths> passed;  // [view] of the hull
  Summary summary;
};

// Throws Error{Input} when no point of space lies inside all marks of the thing.
CarriedThing carry_thing(const CarryDesc& desc, const MarkedThing& thing);
std::optional<CarriedThing> carry_if_marks_meet(const CarryDesc& desc, const MarkedThing& thing);

// What mirrors has no colour of its own; polygons in three photos or more tell its outline all the same.
bool mirror_in_boxes(const MarkedThing& thing);

}  // namespace vitrine
