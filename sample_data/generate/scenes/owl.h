// The statue of the cabinet: an owl of smoothly joined ellipsoids, capsules and rings, carved a little uneven, and painted.
// Its own frame: feet at z = 0, looking towards -y, 0.46 m tall.
#pragma once

#include "sample_data/generate/shape.h"
#include "sample_data/generate/texture.h"

namespace vitrine::generate {

float owl_distance(const Vec3f& p);
Bounds3 owl_bounds();
Vec3f owl_colour(const Vec3f& p);

}  // namespace vitrine::generate
