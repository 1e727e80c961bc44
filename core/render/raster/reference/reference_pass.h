// Reference rasteriser (executable specification): every pixel tests every surfel, sorts its fragments by (z, index) and
// blends. Templated on the scalar so that the gradient tests can evaluate the whole renderer with Dual.
#pragma once

#include <algorithm>
#include <vector>

#include "core/render/raster/kernels/blend.h"
#include "core/render/raster/reference/surfel_values.h"

namespace vitrine::reference {

template <class T>
struct Fragment {
  size_t surfel;
  SplatSample<T> sample;
  T transmittance;  // in front of it
  T weight;
};

// The fragments of one pixel in exact depth order, ties by index, with their weights. `out` is reused.
template <class T>
void collect_fragments(const std::vector<ScreenSurfel<T>>& surfels, T px, T py, std::vector<Fragment<T>>& out) {
  out.clear();
  for (size_t i = 0; i < surfels.size(); ++i) {
    if (!surfels[i].visible) continue;
    const SplatSample<T> sample = splat_sample(surfels[i].constants, px, py);
    if (sample.counts) out.push_back({i, sample, T(0), T(0)});
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.sample.z < b.sample.z; });
  T transmittance(1);
  for (Fragment<T>& f : out) {
    f.transmittance = transmittance;
    f.weight = blend_weight(f.sample.alpha, transmittance);
    transmittance *= T(1) - f.sample.alpha;
  }
}

template <class T>
struct PixelValues {  // of one pixel, or their gradients
  std::array<T, kMaxFeatures> features{};
  T zdepth{}, alpha{}, median_z{}, distortion{};
};

template <class T>
PixelValues<T> blend_pixel(const std::vector<ScreenSurfel<T>>& surfels, const std::vector<Fragment<T>>& fragments,
                           const SceneCamera<T>& view, const Vec3<T>& background) {
  PixelValues<T> out;
  DistortionSums<T> sums;
  for (const Fragment<T>& f : fragments) {
    for (size_t c = 0; c < view.features; ++c) out.features[c] += f.weight * surfels[f.surfel].features[c];
    out.zdepth += f.weight * f.sample.z;
    out.alpha += f.weight;
    sums.add(f.weight, T(1) / f.sample.z);
    if (f.transmittance > T(kMedianTransmittance)) out.median_z = f.sample.z;
  }
  for (size_t c = 0; c < 3; ++c) out.features[c] += (T(1) - out.alpha) * background[c];
  const T k = distortion_scale(view.near_z, view.far_z);
  out.distortion = k * k * sums.value();
  return out;
}

template <class T>
struct SurfelSums {  // over pixels
  SplatMoments<T> moments{};
  std::array<T, kMaxFeatures> features{};
  T weight{}, error{};
};

// Back to front, with the recursion for "behind" of algorithms 1.7.
template <class T>
void blend_pixel_vjp(const std::vector<ScreenSurfel<T>>& surfels, const std::vector<Fragment<T>>& fragments,
                     const SceneCamera<T>& view, const Vec3<T>& background, const PixelValues<T>& grad, T error,
                     std::vector<SurfelSums<T>>& sums) {
  DistortionSums<T> totals;
  size_t median = fragments.size();
  for (size_t i = 0; i < fragments.size(); ++i) {
    totals.add(fragments[i].weight, T(1) / fragments[i].sample.z);
    if (fragments[i].transmittance > T(kMedianTransmittance)) median = i;
  }
  const T k = distortion_scale(view.near_z, view.far_z), grad_spread = k * k * grad.distortion;
  T grad_weight = grad.alpha;
  for (size_t c = 0; c < 3; ++c) grad_weight -= background[c] * grad.features[c];
  T behind(0);  // sum of w_j V_j behind the fragment
  for (size_t n = fragments.size(); n-- > 0;) {
    const Fragment<T>& f = fragments[n];
    const ScreenSurfel<T>& s = surfels[f.surfel];
    SurfelSums<T>& sum = sums[f.surfel];
    const T z = f.sample.z, q = T(1) / z;
    T value = grad_weight + z * grad.zdepth + grad_spread * totals.weight_slope(q);
    for (size_t c = 0; c < view.features; ++c) {
      value += s.features[c] * grad.features[c];
      sum.features[c] += f.weight * grad.features[c];
    }
    const T grad_alpha = blend_vjp(f.transmittance, value, behind, T(1) / (T(1) - f.sample.alpha));
    const T grad_z =
        f.weight * grad.zdepth + (n == median ? grad.median_z : T(0)) + grad_spread * totals.depth_slope(f.weight, q, q);
    sum.moments.add(splat_sample_vjp(f.sample, grad_alpha, grad_z), f.sample.dx, f.sample.dy);
    sum.weight += f.weight;
    sum.error += f.weight * error;
    behind += f.weight * value;
  }
}

}  // namespace vitrine::reference
