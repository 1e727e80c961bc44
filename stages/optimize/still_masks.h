// The surfaces that stand still with the object, and where the photos show them: pixels that dense stereo explains, in the
// photos' agreement, and the flat surface between them (a white plate of which only the rim and a ruler have texture).
#pragma once

#include "stages/optimize/moving_evidence.h"

namespace vitrine {

struct StillPoint {
  Vec3d position, normal;
  double radius;  // of the surface that it stands for
};

// Points of which the photos that look there agree that they stand still with the object.
std::vector<StillPoint> still_points(const Capture& capture, const DenseDepth& dense, const MovingEvidence& evidence);

// Where one photo shows them, at the size of `view`, [h*w]: 255 shown for sure, 128 at the rim, 0 not.
// `object`: its mask there, or empty. What moves in the photo is not shown.
std::vector<uint8_t> shown(const View& view, std::span<const StillPoint> points, std::span<const uint8_t> object,
                           const PhotoEvidence& evidence);

}  // namespace vitrine
