#include "core/render/volume/reference/reference.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/render/volume/kernels/cells.h"
#include "core/render/volume/kernels/density.h"

namespace vitrine {

namespace {

struct OnRay {
  size_t gaussian;
  RayProfile<double> profile;
};

// Those of an optical depth that counts.
std::vector<OnRay> profiles_of(std::span<const Gaussian3d> gaussians, std::span<const Whitened<double>> white,
                               const VolumeRay& ray) {
  constexpr double kLeastDepth = 1e-14;
  std::vector<OnRay> out;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    const RayProfile<double> p = ray_profile(white[i], whitened_line(white[i], gaussians[i].mean, ray.origin, ray.direction));
    if (p.depth > kLeastDepth) out.push_back({i, p});
  }
  return out;
}

std::vector<Whitened<double>> whitened_of(std::span<const Gaussian3d> gaussians) {
  std::vector<Whitened<double>> out;
  for (const Gaussian3d& g : gaussians) out.push_back(whitened(g));
  return out;
}

// f(t, weight) for the points of the quadrature.
template <class F>
void each_point(std::span<const OnRay> profiles, F f) {
  constexpr std::array<double, 5> kPoints{-0.906179845938664, -0.538469310105683, 0, 0.538469310105683, 0.906179845938664};
  constexpr std::array<double, 5> kWeights{0.236926885056189, 0.478628670499366, 0.568888888888889, 0.478628670499366,
                                           0.236926885056189};
  std::vector<double> borders;
  for (const auto& [gaussian, p] : profiles)
    for (const double x : {-6., -4., -2., 0., 2., 4., 6.}) borders.push_back(p.at + x * p.width);
  std::sort(borders.begin(), borders.end());
  for (size_t i = 0; i + 1 < borders.size(); ++i) {
    const double half = 0.5 * (borders[i + 1] - borders[i]), middle = borders[i] + half;
    for (size_t k = 0; k < kPoints.size(); ++k) f(middle + half * kPoints[k], half * kWeights[k]);
  }
}

struct Point {
  double transmittance;
  Vec3d emission;                  // per length
  std::vector<double> x, density;  // of each Gaussian: distance from its peak in standard deviations; density
};

Point point_at(std::span<const OnRay> profiles, std::span<const Vec3d> colors, double t) {
  Point out;
  double depth = 0;
  for (const auto& [gaussian, p] : profiles) {
    const double x = (t - p.at) / p.width, density = p.depth / (p.width * kSqrtTwoPi) * std::exp(-0.5 * x * x);
    depth += p.depth * normal_cdf(x);
    out.emission += density * colors[gaussian];
    out.x.push_back(x), out.density.push_back(density);
  }
  out.transmittance = std::exp(-depth);
  return out;
}

double whole_depth(std::span<const OnRay> profiles) {
  double sum = 0;
  for (const OnRay& on_ray : profiles) sum += on_ray.profile.depth;
  return sum;
}

// Gradients by profiles and colours along one ray for the gradient `g` of its light.
struct OnRayGradient {
  RayProfile<double> profile;
  Vec3d color;
};

std::vector<OnRayGradient> ray_vjp(std::span<const OnRay> profiles, std::span<const Vec3d> colors, const VolumeLightd& g) {
  std::vector<OnRayGradient> out(profiles.size());
  each_point(profiles, [&](double t, double weight) {
    const Point q = point_at(profiles, colors, t);
    const double seen = weight * q.transmittance, by_depth = -seen * dot(g.color, q.emission);
    for (size_t i = 0; i < profiles.size(); ++i) {
      const auto& [gaussian, p] = profiles[i];
      const double by_density = seen * dot(g.color, colors[gaussian]) * q.density[i], x = q.x[i];
      out[i].profile.depth += by_density / p.depth + by_depth * normal_cdf(x);
      out[i].profile.at += by_density * x / p.width - by_depth * q.density[i];
      out[i].profile.width += by_density * (x * x - 1) / p.width - by_depth * q.density[i] * x;
      out[i].color += seen * q.density[i] * g.color;
    }
  });
  const double behind = g.transmittance * std::exp(-whole_depth(profiles));
  for (OnRayGradient& o : out) o.profile.depth -= behind;
  return out;
}

}  // namespace

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

std::vector<VolumeLightd> reference_emission(const EmittingGaussians& volume, std::span<const VolumeRay> rays) {
  const std::vector<Whitened<double>> white = whitened_of(volume.gaussians);
  std::vector<VolumeLightd> out(rays.size());
  parallel_for(rays.size(), 4, [&](size_t r) {
    const std::vector<OnRay> profiles = profiles_of(volume.gaussians, white, rays[r]);
    each_point(profiles, [&](double t, double weight) {
      const Point q = point_at(profiles, volume.colors, t);
      out[r].color += (weight * q.transmittance) * q.emission;
    });
    out[r].transmittance = std::exp(-whole_depth(profiles));
  });
  return out;
}

EmittingGradients reference_emission_vjp(const EmittingGaussians& volume, std::span<const VolumeRay> rays,
                                         std::span<const VolumeLightd> gradient) {
  const size_t count = volume.gaussians.size();
  const std::vector<Whitened<double>> white = whitened_of(volume.gaussians);
  std::vector<std::vector<OnRay>> profiles(rays.size());
  std::vector<std::vector<OnRayGradient>> of_rays(rays.size());
  parallel_for(rays.size(), 4, [&](size_t r) {
    profiles[r] = profiles_of(volume.gaussians, white, rays[r]);
    of_rays[r] = ray_vjp(profiles[r], volume.colors, gradient[r]);
  });
  EmittingGradients out{std::vector<Gaussian3d>(count), std::vector<Vec3d>(count)};
  std::vector<WhitenedGradient<double>> sums(count);
  for (size_t r = 0; r < rays.size(); ++r)
    for (size_t k = 0; k < profiles[r].size(); ++k) {
      const size_t i = profiles[r][k].gaussian;
      ray_profile_vjp(white[i], volume.gaussians[i].mean, rays[r].origin, rays[r].direction, of_rays[r][k].profile, sums[i]);
      out.colors[i] += of_rays[r][k].color;
    }
  for (size_t i = 0; i < count; ++i) out.gaussians[i] = whitened_vjp(volume.gaussians[i], white[i], sums[i]);
  return out;
}

std::vector<VolumeLightd> reference_cells(const EmittingGaussians& volume, std::span<const VolumeRay> rays, const Vec3d& pivot,
                                          std::span<const float> nodes) {
  const std::vector<Whitened<double>> white = whitened_of(volume.gaussians);
  std::vector<VolumeLightd> out(rays.size());
  parallel_for(rays.size(), 4, [&](size_t r) {
    const double nearest = dot(pivot - rays[r].origin, rays[r].direction);
    std::vector<RayCell<double>> cells(nodes.size() + 1);
    const std::vector<OnRay> profiles = profiles_of(volume.gaussians, white, rays[r]);
    for (const auto& [gaussian, p] : profiles) {
      double before = 0;
      for (size_t k = 0; k < cells.size(); ++k) {
        const double t = k < nodes.size() ? nearest + double(nodes[k]) : 0;
        const double now = k < nodes.size() ? normal_cdf((t - p.at) / p.width) : 1;
        const double part = p.depth * (now - before);
        cells[k].depth += part;
        cells[k].emission += part * volume.colors[gaussian];
        before = now;
      }
    }
    out[r].transmittance = 1;
    for (const auto& cell : cells) add_cell(cell, std::exp(-cell.depth), out[r]);
  });
  return out;
}

}  // namespace vitrine
