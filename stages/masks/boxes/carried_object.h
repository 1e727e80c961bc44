// Propagation of one marked object from a few marked photos to all photos (method: marked_source.h).
#pragma once

#include <optional>

#include "core/observe/stereo/small_stereo.h"
#include "stages/masks/boxes/marks_file.h"
#include "stages/masks/mask_source.h"

namespace vitrine {

inline constexpr int kHullVoxels = 96;  // along the longest side of a marked object

struct CarryDesc {
  const MaskCapture& capture;
  const std::vector<View>& views;         // of the capture, at the small size
  const std::vector<SmallPhoto>& photos;  // same views with colours; may be empty when all objects are glass
  const SmallStereo* stereo = nullptr;    // to predict the background of mirrors marked with boxes
  int hull_voxels = kHullVoxels;
};

struct CarriedObject {
  struct Summary {
    std::string name, word;  // MarkedObject
    MaskClass kind;
    size_t marks = 0, refined = 0;  // photos marked; photos whose outline was found by segmentation (not by a polygon)
    double edge = 0;                // longest edge of the visual hull's box, scene units
    bool voted = false;             // the masks come from the second hull
    size_t solids = 0;              // surfaces of revolution found in it
    double box_agreement = 0;       // IoU with the box that replaces it; 0 = no box
  };
  std::vector<std::vector<uint8_t>> inside, doubted;  // [view][h,w]; doubted: outline and hull disagree
  VisualHull hull;
  std::vector<HullDepths> passed;  // [view] of the hull
  Summary summary;
};

// Throws Error{Input} when the cones of the marks have no common point.
CarriedObject carry_object(const CarryDesc& desc, const MarkedObject& object);
std::optional<CarriedObject> carry_if_marks_meet(const CarryDesc& desc, const MarkedObject& object);

// A mirror has no colour of its own, so colour segmentation fails; polygons in at least three photos define it anyway.
bool mirror_in_boxes(const MarkedObject& object);

}  // namespace vitrine
