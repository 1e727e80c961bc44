// Did the camera only turn? Two photos from one place are related by H = K R K^-1, whatever they show. A plane seen from two
// places has a homography, too, but K^-1 H K is then no rotation.
#pragma once

#include <span>

#include "stages/sfm/database.h"

namespace vitrine {

// Of the verified pairs, the share that one focal length explains as rotations (the best one of a range is taken). Photos that
// show the same without a turn do not count. Principal point in the middle; all photos of one size.
double rotation_share(std::span<const VerifiedPair> pairs, int width, int height);

}  // namespace vitrine
