// Turntable detection: the object turns while camera and room are static. The room then seems to move against the object, and
// only the object's features may be used for pose estimation.
//
// Evidence: matches between photos close in name order. On a turntable, matches outside the object mask stay in place and those
// inside move. A moving camera moves all matches outside; a static camera with a static object moves none inside.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "stages/sfm/database.h"

namespace vitrine {

struct TurntableEvidence {
  size_t pairs = 0;          // examined pairs
  size_t outside_told = 0;   // pairs with enough matches outside the mask
  size_t outside_still = 0;  // of these: most outside matches stay in place
  size_t inside_told = 0;    // pairs with enough matches inside the mask
  size_t inside_moves = 0;   // of these: most inside matches move
  bool turntable = false;
  std::string why;  // a sentence with these figures
};

struct TurntableDesc {
  std::span<const PhotoFeatures> photos;         // in name order
  std::span<const std::vector<uint8_t>> inside;  // [photo][feature] 1 = on the object; empty: this photo has no mask
  std::span<const double> sides;                 // [photo] longest side of the picture, pixels
};

TurntableEvidence turntable_evidence(const TurntableDesc& desc);

}  // namespace vitrine
