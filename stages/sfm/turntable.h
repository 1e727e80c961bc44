// Does the object turn while camera and room stand still? Then the room is what seems to move against the object, and only the
// object may be used to find the cameras.
//
// The proof is in the matches between photos that are close in name order: outside the object's mask they stay where they are,
// inside they move. A camera that moves leaves nothing in place outside; a camera that stands before a still life moves nothing
// inside.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "stages/sfm/database.h"

namespace vitrine {

struct TurntableEvidence {
  size_t pairs = 0;          // looked at
  size_t outside_told = 0;   // with enough matches outside the mask to tell
  size_t outside_still = 0;  // of these: most outside matches stay in place
  size_t inside_told = 0;    // with enough matches inside
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
