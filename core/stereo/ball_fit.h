// A ball among the surfaces of revolution. Photos from one height see no silhouette of its top and its foot, things in front hide
// parts of it, and a profile that is free ends in cones there. A sphere has four numbers, which any part of it tells.
#pragma once

#include <optional>
#include <span>

#include "core/shape/surface_of_revolution.h"
#include "core/stereo/silhouette.h"

namespace vitrine {

// The sphere through the flank of `surface`, about its axis, where most photos show it as well as `surface` itself; else nullopt.
std::optional<SurfaceOfRevolution> ball_of(std::span<const Silhouette> silhouettes, const SurfaceOfRevolution& surface);

}  // namespace vitrine
