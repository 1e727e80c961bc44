// Captures whose surroundings do not stand still with the object: a turntable, a plain backdrop. Trained along, the backdrop of
// each photo becomes a veil before the object as the others see it. There the object is trained alone, against its masks.
#pragma once

#include <string>

#include "core/train/capture.h"
#include "core/train/targets.h"

namespace vitrine {

// Share of the sparse points' sightings by photos with an object mask that lie outside it; 1 without masks or points.
double sightings_outside_object(const Capture& capture, const Targets& targets);

// `wanted`: ignore, train, or auto: less than a tenth of the sightings lie outside the masks, and the masks are no proposals.
bool object_alone(const std::string& wanted, const Capture& capture, const Targets& targets);

// Whether the masks allow it: at most a tenth of the photos with an object mask that have the point in the picture see it
// outside.
bool on_object(const Capture& capture, const Targets& targets, const Vec3d& position);

}  // namespace vitrine
