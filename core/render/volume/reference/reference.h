// Volumes in double, every ray through every Gaussian: the executable specification of LineIntegrals and EmissionAbsorption.
#pragma once

#include <span>
#include <vector>

#include "core/render/volume/kernels/profile.h"
#include "core/render/volume/volume_ray.h"

namespace vitrine {

// Density times length per ray: dimensionless.
std::vector<double> reference_line_integrals(std::span<const Gaussian3d> gaussians, std::span<const VolumeRay> rays);
// Gradient for dL/d(integral) `gradient`, one value per ray.
std::vector<Gaussian3d> reference_line_integrals_vjp(std::span<const Gaussian3d> gaussians, std::span<const VolumeRay> rays,
                                                     std::span<const double> gradient);

// Volumes that absorb and emit: the integral itself by quadrature, which is the truth for the fast path, and its cells.
struct EmittingGaussians {
  std::span<const Gaussian3d> gaussians;
  std::span<const Vec3d> colors;  // radiance of each Gaussian where it is opaque
};
// In the order of EmittingGaussians.
struct EmittingGradients {
  std::vector<Gaussian3d> gaussians;
  std::vector<Vec3d> colors;
};

// Integral over t of sum_i colour_i density_i(t) exp(-optical depth before t), by Gauss-Legendre quadrature of five points
// between all distances at 0, 2, 4 and 6 standard deviations of each Gaussian; optical depths are closed forms.
std::vector<VolumeLightd> reference_emission(const EmittingGaussians& volume, std::span<const VolumeRay> rays);
// Gradient for dL/d(light) `gradient`, one per ray.
EmittingGradients reference_emission_vjp(const EmittingGaussians& volume, std::span<const VolumeRay> rays,
                                         std::span<const VolumeLightd> gradient);

// With cells (kernels/cells.h) between `nodes`: distances from the point of each ray that is nearest to `pivot`.
std::vector<VolumeLightd> reference_cells(const EmittingGaussians& volume, std::span<const VolumeRay> rays, const Vec3d& pivot,
                                          std::span<const float> nodes);

}  // namespace vitrine
