// How high walls stand that no photo shows: polished things show it. What they mirror is trained into the reflection layer, and
// seen from their middle it is dark where walls are and bright where the sky is.
#pragma once

#include <optional>
#include <span>

#include "core/scene/layers.h"
#include "stages/decompose/lit_points.h"

namespace vitrine {

// Sine of the elevation at which the light half-way between walls and sky is crossed (medians over the azimuths): the edge that a
// rough or coarse mirror shows softened. Nothing, where too few of the points are polished, where their mirrors never looked, or
// where what is high up is not at least twice as bright.
std::optional<float> mirrored_horizon(const SplatLayer& reflection, std::span<const LitPoint> points);

}  // namespace vitrine
