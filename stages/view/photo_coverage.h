// Coverage of each surfel of a page by the training photos: their number and their angular spread. Surfels seen by few photos, or
// from one side only, are badly constrained.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

struct PhotoCoverage {
  int photos = 0;
  double widest_deg = 0;  // largest angle at the surfel between two of them
};

// Coverage of the rendered surfels. A photo sees a surfel if its centre is inside the image and at least 5 % of its unoccluded
// blending weight remains. Glass occludes only surfels of glass.
std::vector<PhotoCoverage> photo_coverage(const PageSurfels& surfels, std::span<const View> photos, float near_z);

// 8 min(photos, 12) + min(floor(angle / 10 degrees), 6).
uint8_t coverage_byte(const PhotoCoverage& coverage);

// Writes the block seen: one byte per rendered surfel.
void add_coverage(std::span<const PhotoCoverage> coverage, PageBlocks& blocks);

}  // namespace vitrine
