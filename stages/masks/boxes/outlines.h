// Segmentation of marked objects near the silhouette of their visual hull: by colour, or by comparison with the predicted
// background.
#pragma once

#include <cstdint>
#include <vector>

#include "core/observe/stereo/background.h"
#include "core/observe/stereo/small_stereo.h"
#include "core/scene/camera/view.h"
#include "stages/masks/mask_source.h"

namespace vitrine {

// Colour segmentation: GrabCut (Rother et al. 2004). Returns [h,w] 1 = object. `about`: silhouette of the hull; `tight`: only its
// edge is uncertain, its interior belongs to the object whatever its colours (a mirror has those of its surroundings). Empty when
// the silhouette has too few pixels, no background remains, or the result hardly overlaps it.
std::vector<uint8_t> grab_cut(const SmallPhoto& photo, const std::vector<uint8_t>& about, bool tight);

// Segmentation by the predicted background (core/observe/stereo/background.h).
class PastOutlines {
 public:
  explicit PastOutlines(const SmallStereo& stereo) : stereo_(stereo) {}  // refers to it

  // For HullDesc.
  std::vector<HalfSpace> sides(const VisualHull& hull) const;
  // [view][h,w] 1 where another surface occludes a hull that is certain to contain the object.
  std::vector<std::vector<uint8_t>> hidden(const VisualHull& around) const;
  // [view] coverage 0 or 1 of the object in the hull; negative in `hidden` pixels. Stops early on an interrupt.
  std::vector<Silhouette> outlines(const VisualHull& hull, std::span<const std::vector<uint8_t>> hidden) const;

 private:
  const SmallStereo& stereo_;
};

// Pixels of the appendages of a surface of revolution. A visual hull of few marks contains an appendage up to its root, but is
// too wide along the silhouette of the body next to it.

// All images are [h,w] of `k`, 0 or 1. `solid`: silhouette of the body; `off`: hull pixels outside it; `far`: those of them whose
// surface is far from the body. Returns the body, the far pixels and the pixels that connect them to the body.
std::vector<uint8_t> with_appendages(const std::vector<uint8_t>& solid, const std::vector<uint8_t>& off,
                                     const std::vector<uint8_t>& far, const Intrinsics& k);

}  // namespace vitrine
