// Reference ray tracer (executable specification): every ray tests every surfel, sorts its hits by (t, index) and blends.
// Templated on the scalar so that the gradient tests can evaluate the whole tracer with Dual.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/render/raster/reference/surfel_values.h"
#include "core/render/trace/kernels/march.h"
#include "core/render/trace/kernels/ray_splat.h"

namespace vitrine::reference {

template <class T>
struct TraceSurfel {
  RaySurfel<T> shape;
  std::array<T, 3 * kMaxShCoefficients> sh{};
};

template <class T>
TraceSurfel<T> trace_surfel(const SurfelValues<T>& raw) {
  return {ray_surfel(raw.geometry, sigmoid(raw.opacity)), raw.sh};
}

template <class T>
struct MarchDesc {
  int sh_degree = 0;
  T min_transmittance{}, first_hit_weight{};
};

template <class T>
struct BlendedHit {
  size_t surfel = 0;
  RayHit<T> hit{};
  Vec3<T> color{}, normal{};
  T transmittance{};  // in front of it
  bool first = false;
};

// The blended hits of one ray in exact order, with their weights, and the sums. `out` is reused.
template <class T>
MarchValues<T> trace_ray(const std::vector<TraceSurfel<T>>& surfels, const TraceRay<T>& ray, const MarchDesc<T>& desc,
                         std::vector<BlendedHit<T>>& out) {
  out.clear();
  T basis[kMaxShCoefficients];
  sh_basis(desc.sh_degree, ray.direction, basis);
  for (size_t i = 0; i < surfels.size(); ++i) {
    BlendedHit<T> h;
    h.surfel = i;
    h.hit = ray_splat(surfels[i].shape, ray);
    if (h.hit.counts) out.push_back(h);
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.hit.t < b.hit.t; });
  March<T> march;
  size_t blended = 0;
  while (blended < out.size() && march.sum.transmittance >= desc.min_transmittance) {
    BlendedHit<T>& h = out[blended++];
    const TraceSurfel<T>& s = surfels[h.surfel];
    h.color = ray_color(desc.sh_degree, basis, s.sh.data());
    h.normal = dot(s.shape.normal, ray.direction) > T(0) ? -s.shape.normal : s.shape.normal;
    h.transmittance = march.sum.transmittance;
    const bool before = march.weight < desc.first_hit_weight;
    march.blend(h.hit.t, h.hit.alpha, h.color, h.normal, desc.first_hit_weight);
    h.first = before && march.weight >= desc.first_hit_weight;
  }
  out.resize(blended);
  return march.sum;
}

template <class T>
struct TraceSums {  // over rays
  HitMoments<T> moments{};
  std::array<T, 3 * kMaxShCoefficients> sh{};
  Vec3<T> screen{};  // mean's gradient times t/2
  T weight{}, error{};
};

template <class T>
struct RayGrad {
  Vec3<T> origin{}, direction{};
};

// `hits` and `values` are those of trace_ray. Adds to `sums`.
template <class T>
RayGrad<T> trace_ray_vjp(const std::vector<TraceSurfel<T>>& surfels, const TraceRay<T>& ray, const MarchDesc<T>& desc,
                         const std::vector<BlendedHit<T>>& hits, const MarchValues<T>& values, const MarchValues<T>& grad,
                         T error, std::vector<TraceSums<T>>& sums) {
  RayGrad<T> out;
  T basis[kMaxShCoefficients], basis_weight[kMaxShCoefficients] = {};
  sh_basis(desc.sh_degree, ray.direction, basis);
  T behind = values.transmittance * grad.transmittance;
  for (size_t n = hits.size(); n-- > 0;) {
    const BlendedHit<T>& h = hits[n];
    const TraceSurfel<T>& s = surfels[h.surfel];
    TraceSums<T>& sum = sums[h.surfel];
    const BlendGrad<T> b = blend_hit_vjp(h.transmittance, h.hit.t, h.hit.alpha, h.color, h.normal, h.first, grad, behind);
    const bool flipped = dot(s.shape.normal, ray.direction) > T(0);
    const HitGrad<T> g = ray_splat_vjp(s.shape, ray, h.hit, b.alpha, b.t, flipped ? -b.normal : b.normal);
    sum.moments += g.moments;
    out.origin += g.origin;
    out.direction += g.direction;
    ray_color_vjp(desc.sh_degree, basis, s.sh.data(), h.color, b.color, sum.sh.data(), basis_weight);
    sum.screen -= T(0.5) * h.hit.t * g.origin;  // moving the surfel by dx equals moving the ray origin by -dx
    const T w = h.transmittance * h.hit.alpha;
    sum.weight += w;
    sum.error += w * error;
  }
  out.direction += sh_basis_vjp(desc.sh_degree, ray.direction, basis_weight);
  return out;
}

}  // namespace vitrine::reference
