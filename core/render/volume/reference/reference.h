// Line integrals in double, every ray through every Gaussian: the executable specification of LineIntegrals.
#pragma once

#include <span>
#include <vector>

#include "core/render/volume/gaussian3.h"
#include "core/render/volume/volume_ray.h"

namespace vitrine {

// Density times length per ray: dimensionless.
std::vector<double> reference_line_integrals(std::span<const Gaussian3d> gaussians, std::span<const VolumeRay> rays);
// Gradient for dL/d(integral) `gradient`, one value per ray.
std::vector<Gaussian3d> reference_line_integrals_vjp(std::span<const Gaussian3d> gaussians, std::span<const VolumeRay> rays,
                                                     std::span<const double> gradient);

}  // namespace vitrine
