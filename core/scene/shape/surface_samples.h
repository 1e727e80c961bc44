// Uniform samples on the surface of a shape, for placing surfels.
#pragma once

#include <vector>

#include "core/scene/shape/shape.h"

namespace vitrine {

// About one point per square of edge `spacing` > 0: a low-discrepancy sequence per triangle (Roberts, "The unreasonable
// effectiveness of quasirandom sequences", 2018), projected onto the surface. Deterministic.
std::vector<ShapePoint> surface_samples(const Shape& shape, double spacing);

}  // namespace vitrine
