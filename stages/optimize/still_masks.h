// Masks of the surfaces that are static relative to the object. They cover pixels that dense stereo explains consistently in
// several photos, and the flat surface between them (a white plate with texture only on its rim and a ruler).
#pragma once

#include "stages/optimize/moving_evidence.h"

namespace vitrine {

struct StillPoint {
  Vec3d position, normal;
  double radius;  // of the surface patch that the point represents
};

// Points that the photos consistently show as static relative to the object.
std::vector<StillPoint> still_points(const Capture& capture, const DenseDepth& dense, const MovingEvidence& evidence);

// Mask of the static surface in one photo, at the size of `view`, [h*w]: 255 certain, 128 at the boundary, 0 outside. `object`:
// object mask at that size, or empty. Moving pixels of the photo are excluded.
std::vector<uint8_t> shown(const View& view, std::span<const StillPoint> points, std::span<const uint8_t> object,
                           const PhotoEvidence& evidence);

}  // namespace vitrine
