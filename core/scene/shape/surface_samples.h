// Points on the surface of a shape, evenly by area: where surfels of a known shape are put.
#pragma once

#include <vector>

#include "core/scene/shape/shape.h"

namespace vitrine {

// About one point in every square of edge `spacing` > 0, a low-discrepancy sequence in every triangle (Roberts, "The unreasonable
// effectiveness of quasirandom sequences", 2018), moved onto the surface. The same points whenever it is called.
std::vector<ShapePoint> surface_samples(const Shape& shape, double spacing);

}  // namespace vitrine
