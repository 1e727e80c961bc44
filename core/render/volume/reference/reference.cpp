#include "core/render/volume/reference/reference.h"

#include "core/foundation/base/parallel.h"
#include "core/render/volume/kernels/density.h"

namespace vitrine {

std::vector<double> reference_line_integrals(std::span<const Gaussian3d> gaussians, std::span<const VolumeRay> rays) {
  std::vector<Whitened<double>> prepared;
  for (const Gaussian3d& g : gaussians) prepared.push_back(whitened(g));
  std::vector<double> out(rays.size());
  parallel_for(rays.size(), 16, [&](size_t r) {
    for (size_t i = 0; i < gaussians.size(); ++i)
      out[r] += line_integral(prepared[i], whitened_line(prepared[i], gaussians[i].mean, rays[r].origin, rays[r].direction));
  });
  return out;
}

std::vector<Gaussian3d> reference_line_integrals_vjp(std::span<const Gaussian3d> gaussians, std::span<const VolumeRay> rays,
                                                     std::span<const double> gradient) {
  std::vector<Gaussian3d> out(gaussians.size());
  parallel_for(gaussians.size(), 4, [&](size_t i) {
    const Gaussian3d& g = gaussians[i];
    const Whitened<double> w = whitened(g);
    WhitenedGradient<double> sums;
    for (size_t r = 0; r < rays.size(); ++r) line_integral_vjp(w, g.mean, rays[r].origin, rays[r].direction, gradient[r], sums);
    out[i] = whitened_vjp(g, w, sums);
  });
  return out;
}

}  // namespace vitrine
