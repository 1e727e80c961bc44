// Which pixels of the specular masks show no known mirror: a coat, paint under a clear layer (ShapeRole::Coat), or gloss of which
// no shape is known. They leave the specular mask, so that nothing takes what their surfels show for a mirror image: these stay,
// their losses count in full, no hull is carved of them.
#pragma once

#include "core/shape/shape_set.h"
#include "core/train/capture.h"
#include "core/train/targets.h"

namespace vitrine {

// Moves these pixels from the specular masks to TargetLevel::coat. A pixel belongs to the first coat or mirror that its ray
// meets; pixels at the rim of a mask whose rays meet nothing belong to what is beside them, and to no mirror farther inside.
void separate_coats(const Capture& capture, const ShapeSet& shapes, Targets& targets);

}  // namespace vitrine
