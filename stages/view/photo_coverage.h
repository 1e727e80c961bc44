// How well the photos saw each surfel of a page: how many of them, and from how far apart. Surfels that few photos saw, or all
// from one side, are what the training had to guess.
#pragma once

#include <span>
#include <vector>

#include "core/camera/view.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

struct PhotoCoverage {
  int photos = 0;
  double widest_deg = 0;  // the greatest angle at the surfel between two of them
};

// Of the drawn surfels. A photo sees a surfel whose middle lies in it, where at least a twentieth of what the surfel would give
// to an empty picture passes the surfels before it. Glass hides no surfel but those of glass behind it.
std::vector<PhotoCoverage> photo_coverage(const PageSurfels& surfels, std::span<const View> photos, float near_z);

// 8 min(photos, 12) + min(floor(angle / 10 degrees), 6).
uint8_t coverage_byte(const PhotoCoverage& coverage);

// Block seen: a byte of each drawn surfel.
void add_coverage(std::span<const PhotoCoverage> coverage, PageBlocks& blocks);

}  // namespace vitrine
