// Surfaces of revolution about the vertical axis through the origin: a profile of points (radius, height), in metres, turned
// once around. The outside is on the right of the way along the profile: a wall that goes up faces away from the axis.
#pragma once

#include <span>
#include <vector>

#include "sample_data/generate/shape.h"

namespace vitrine::generate {

using Profile = std::vector<Vec2f>;  // x: radius >= 0, y: height

// A smooth curve through the knots (Catmull-Rom), `steps` pieces from knot to knot. Radii stay above zero.
Profile smooth_profile(std::span<const Vec2f> knots, int steps);
// Normals are smooth except where the profile turns by more than 35 degrees. uv is 0.
Shape revolved(std::span<const Vec2f> profile, int around);

}  // namespace vitrine::generate
