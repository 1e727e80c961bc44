// The reverse pass, without atomics. Fragments are listed by pixel in depth order (FragmentSink of blend_kernel.h); a thread for
// each pixel goes through its list from back to front and leaves the gradients of each fragment's alpha and z; sorted by instance
// (stable: pixels in order), a thread for each instance adds up what its fragments contribute; a thread for each surfel adds up
// its instances in the order of their tiles and goes back to the raw values. So every sum of floats has one owner and one order.
#pragma once

#include "core/render/raster/blocks/blend_kernel.h"

namespace vitrine::blocks {

// dL/d(plane), [h, w]; null: zero.
struct GradientPlanes {
  const float* features[kMaxFeatures];
  const float *zdepth, *alpha, *median_z, *distortion, *error;
  VITRINE_HD static F32 at(const float* plane, size_t pixel) { return plane == nullptr ? 0.f : plane[pixel]; }
};

struct SweptInstances {
  const uint32_t* surfels;  // of the sorted instances
  const SurfelRecord* records;
  VITRINE_HD const SurfelRecord& record(uint32_t instance) const { return records[surfels[instance]]; }
};

VITRINE_HD inline SplatSample<F32> sample_of(const SurfelRecord& record, uint32_t pixel, const BlockView& view) {
  const uint32_t width = static_cast<uint32_t>(view.width);
  const F32 px(static_cast<float>(pixel % width) + 0.5f), py(static_cast<float>(pixel / width) + 0.5f);
  return splat_sample(record.constants, px, py);
}

template <int kFeatures, bool kDistortion>
struct PixelReverseKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  BlockView view;
  SweptInstances instances;
  const uint32_t* offsets;  // of each pixel, into the fragments
  const uint32_t* counts;   // of each pixel
  FragmentList fragments;
  GradientPlanes in;
  uint32_t pixels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t pixel = at.block * kThreads + at.thread;
    if (pixel >= pixels || counts[pixel] == 0) return;
    const uint32_t begin = offsets[pixel], end = begin + counts[pixel];
    const F32 pivot = reciprocal(sample_of(instances.record(fragments.instance[begin]), pixel, view).z);
    DistortionSums<F32> totals;
    uint32_t median = end;
    for (uint32_t i = begin; i < end; ++i) {
      const F32 through(fragments.transmittance[i]);
      if (through > F32(kMedianTransmittance)) median = i;
      if constexpr (kDistortion) {
        const SplatSample<F32> f = sample_of(instances.record(fragments.instance[i]), pixel, view);
        totals.add(blend_weight(f.alpha, through), reciprocal(f.z) - pivot);
      }
    }
    F32 g[kFeatures], grad_weight = in.at(in.alpha, pixel), spread = 0.f;
    for (int c = 0; c < kFeatures; ++c) {
      g[c] = in.at(in.features[c], pixel);
      if (c < 3) grad_weight -= F32(view.background[c]) * g[c];
    }
    const F32 grad_zdepth = in.at(in.zdepth, pixel), grad_median = in.at(in.median_z, pixel);
    if constexpr (kDistortion) {
      const F32 k = distortion_scale(F32(view.near_z), F32(view.far_z));
      spread = k * k * in.at(in.distortion, pixel);
    }
    F32 behind = 0.f;  // sum of w V behind the fragment
    for (uint32_t i = end; i-- > begin;) {
      const SurfelRecord& record = instances.record(fragments.instance[i]);
      const SplatSample<F32> f = sample_of(record, pixel, view);
      const F32 through(fragments.transmittance[i]), w = blend_weight(f.alpha, through), inv_z = reciprocal(f.z),
                                                     q = inv_z - pivot;
      F32 value = grad_weight + f.z * grad_zdepth, grad_z = w * grad_zdepth;
      if constexpr (kDistortion) {
        value += spread * totals.weight_slope(q);
        grad_z += spread * totals.depth_slope(w, q, inv_z);
      }
      if (i == median) grad_z += grad_median;
      for (int c = 0; c < kFeatures; ++c) value += F32(record.features[c]) * g[c];
      fragments.grad_alpha[i] = blend_vjp(through, value, behind, reciprocal(F32(1.f) - f.alpha)).v;
      fragments.grad_z[i] = grad_z.v;
      behind += w * value;
    }
  }
};

// Sums over the fragments of a surfel in a tile.
struct InstanceSums {
  SplatMoments<F32> moments;
  F32 features[kMaxFeatures], weight, error;
  VITRINE_HD void clear() {
    moments = {};
    for (F32& f : features) f = 0.f;
    weight = error = 0.f;
  }
  VITRINE_HD void add(const InstanceSums& o) {
    const SplatMoments<F32>& m = o.moments;
    moments.num_u += m.num_u;
    moments.num_u_x += m.num_u_x;
    moments.num_u_y += m.num_u_y;
    moments.num_v += m.num_v;
    moments.num_v_x += m.num_v_x;
    moments.num_v_y += m.num_v_y;
    moments.den += m.den;
    moments.den_x += m.den_x;
    moments.den_y += m.den_y;
    moments.disc_x += m.disc_x;
    moments.disc_y += m.disc_y;
    moments.weight += m.weight;
    moments.z0 += m.z0;
    for (size_t c = 0; c < kMaxFeatures; ++c) features[c] += o.features[c];
    weight += o.weight;
    error += o.error;
  }
};

// Keys for the sort of the fragments: their instance.
struct FragmentKeyKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint32_t* instance;
  SortedPairs out;
  uint32_t size;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= size) return;
    out.keys[i] = instance[i];
    out.values[i] = i;
  }
};

template <int kFeatures>
struct InstanceReverseKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  BlockView view;
  SweptInstances instances;
  const uint32_t* place;  // of each sorted instance among those of all surfels, surfel by surfel
  SortedPairs sorted;     // fragments by instance
  FragmentList fragments;
  GradientPlanes in;
  InstanceSums* out;
  uint32_t instance_count, fragment_count;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t instance = at.block * kThreads + at.thread;
    if (instance >= instance_count) return;
    InstanceSums sums;
    sums.clear();
    const SurfelRecord& record = instances.record(instance);
    for (uint32_t k = first_at_least(sorted.keys, fragment_count, instance); k < fragment_count && sorted.keys[k] == instance;
         ++k) {
      const uint32_t i = sorted.values[k], pixel = fragments.pixel[i];
      const SplatSample<F32> f = sample_of(record, pixel, view);
      const F32 w = blend_weight(f.alpha, F32(fragments.transmittance[i]));
      sums.moments.add(splat_sample_vjp(f, F32(fragments.grad_alpha[i]), F32(fragments.grad_z[i])), f.dx, f.dy);
      for (int c = 0; c < kFeatures; ++c) sums.features[c] += w * in.at(in.features[c], pixel);
      sums.weight += w;
      sums.error += w * in.at(in.error, pixel);
    }
    out[place[instance]] = sums;
  }
};

// Gradients of the raw values of every surfel, in the arrays of SurfelArrays; zero where it is not visible. Materials may be
// null.
struct SurfelGradients {
  float *mean, *rotation, *log_scale, *opacity, *sh_dc, *sh_rest;
  float* material[4];
  float *screen_gradient, *weight, *error;
};

struct SurfelReverseKernel {
  static constexpr uint32_t kThreads = 64;
  using Shared = NoShared;
  using Thread = NoThread;
  SurfelArrays surfels;
  BlockView view;
  const SurfelRecord* records;
  const InstanceSums* sums;
  const uint32_t* offsets;  // of each surfel, into the sums
  uint32_t instances;
  SurfelGradients out;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= surfels.count) return;
    const uint32_t begin = offsets[i], end = i + 1 < surfels.count ? offsets[i + 1] : instances;
    InstanceSums sum;
    sum.clear();
    for (uint32_t k = begin; k < end; ++k) sum.add(sums[k]);
    out.weight[i] = sum.weight.v;
    out.error[i] = sum.error.v;
    SurfelGeometry<F32> g;
    F32 opacity_grad = 0.f, screen = 0.f;
    Vec3<F32> mean_of_colour;
    if (begin < end) {
      const SurfelGeometry<F32> geometry = geometry_of(surfels, i);
      const Projection<F32> p = project(geometry, view.camera);
      const SplatGrad<F32> splat = splat_grad(sum.moments, p.map, F32(records[i].constants.opacity));
      const Vec3<F32> grad_normal{sum.features[kNormalAt], sum.features[kNormalAt + 1], sum.features[kNormalAt + 2]};
      const ProjectionGrad<F32> back = project_vjp(geometry, view.camera, p, splat.map, grad_normal);
      g = back.surfel;
      opacity_grad = splat.raw_opacity;
      const F32 sx = back.screen_x * F32(0.5f * static_cast<float>(view.width)),
                sy = back.screen_y * F32(0.5f * static_cast<float>(view.height));
      screen = sqrt(sx * sx + sy * sy);
      mean_of_colour = colour_reverse(i, geometry.mean, {sum.features[0], sum.features[1], sum.features[2]});
    } else {
      clear_colour(i);
    }
    for (size_t c = 0; c < 3; ++c) out.mean[size_t{3} * i + c] = (g.mean[c] + mean_of_colour[c]).v;
    const F32 q[] = {g.rotation.w, g.rotation.x, g.rotation.y, g.rotation.z};
    for (size_t c = 0; c < 4; ++c) out.rotation[size_t{4} * i + c] = q[c].v;
    out.log_scale[size_t{2} * i] = g.log_su.v;
    out.log_scale[size_t{2} * i + 1] = g.log_sv.v;
    out.opacity[i] = opacity_grad.v;
    out.screen_gradient[i] = screen.v;
    if (out.material[0] == nullptr) return;
    for (size_t m = 0; m < kMaterialWidth; ++m) {
      const F32 a(begin < end ? records[i].features[kMaterialAt + m] : 0.f);
      float& to = m < 3 ? out.material[0][size_t{3} * i + m] : out.material[m - 2][i];
      to = (sum.features[kMaterialAt + m] * a * (F32(1.f) - a)).v;
    }
  }

  VITRINE_HD void clear_colour(uint32_t i) const {
    for (size_t k = 0; k < 3; ++k) out.sh_dc[size_t{3} * i + k] = 0;
    for (size_t k = 0; k < surfels.sh_rest_width; ++k) out.sh_rest[size_t{surfels.sh_rest_width} * i + k] = 0;
  }
  VITRINE_HD Vec3<F32> colour_reverse(uint32_t i, const Vec3<F32>& mean, const Vec3<F32>& grad) const {
    switch (view.sh_degree) {
      case 0:
        return colour_reverse_of_degree<0>(i, mean, grad);
      case 1:
        return colour_reverse_of_degree<1>(i, mean, grad);
      case 2:
        return colour_reverse_of_degree<2>(i, mean, grad);
      default:
        return colour_reverse_of_degree<3>(i, mean, grad);
    }
  }
  template <int kDegree>
  VITRINE_HD Vec3<F32> colour_reverse_of_degree(uint32_t i, const Vec3<F32>& mean, const Vec3<F32>& grad) const {
    constexpr size_t kCount = 3 * sh_coefficient_count(kDegree);
    F32 h[kCount], grad_h[kCount];
    coefficients_of<kCount>(surfels, i, h);
    const ShColour<F32> colour = sh_colour(kDegree, mean, view.camera.eye, h);
    const Vec3<F32> grad_mean = sh_colour_vjp(kDegree, colour, h, grad, grad_h);
    for (size_t k = 0; k < 3; ++k) out.sh_dc[size_t{3} * i + k] = grad_h[k].v;
    for (size_t k = 3; k < kCount; ++k) out.sh_rest[size_t{surfels.sh_rest_width} * i + k - 3] = grad_h[k].v;
    for (size_t k = kCount; k < 3 + surfels.sh_rest_width; ++k) out.sh_rest[size_t{surfels.sh_rest_width} * i + k - 3] = 0;
    return grad_mean;
  }
};

}  // namespace vitrine::blocks
