// The reverse of the passes. Blending again, with a FragmentSink, lists the fragments of each pixel in depth order and marks the
// pixels of each instance, which gives the place of every fragment among those of its instance without a sort; a thread for each
// pixel goes through its list back to front and leaves the gradients of each fragment's alpha and z there; 32 threads for each
// instance add up what its fragments contribute, each those of eight pixels; a thread for each surfel adds up its instances in
// the order of their tiles and goes back to the raw values. So every sum of floats has one owner and one order.
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

// Of the fragments, instance by instance, each in the order of its pixels.
struct InstanceFragments {
  const uint32_t* offsets;  // of each instance: the fragments of those before it
  PixelMasks masks;
  struct Values {
    float transmittance, grad_alpha, grad_z;
  };
  Values* values;
};

// values[i] = 0.
template <class T>
struct ClearKernel {
  static constexpr uint32_t kThreads = 256;
  using Shared = NoShared;
  using Thread = NoThread;
  T* values;
  size_t size;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const size_t i = size_t{at.block} * kThreads + at.thread;
    if (i < size) values[i] = T(0);
  }
};

// Fragments of each instance.
struct MaskCountKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  PixelMasks masks;
  uint32_t* counts;
  uint32_t instances;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= instances) return;
    uint32_t sum = 0;
    for (uint32_t k = 0; k < PixelMasks::kWords; ++k) sum += bit_count(masks.of(i)[k]);
    counts[i] = sum;
  }
};

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
  InstanceFragments out;
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
    const uint32_t width = static_cast<uint32_t>(view.width), place = PixelMasks::place(pixel % width, pixel / width);
    F32 behind = 0.f;  // sum of w V behind the fragment
    for (uint32_t i = end; i-- > begin;) {
      const uint32_t instance = fragments.instance[i];
      const SurfelRecord& record = instances.record(instance);
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
      out.values[out.offsets[instance] + out.masks.rank(instance, place)] = {
          through.v, blend_vjp(through, value, behind, reciprocal(F32(1.f) - f.alpha)).v, grad_z.v};
      behind += w * value;
    }
  }
};

// Sums over the fragments of a surfel in a tile. In memory: the moments, the blended channels, weight and error.
struct InstanceSums {
  static constexpr uint32_t kMoments = sizeof(SplatMoments<F32>) / sizeof(F32);
  VITRINE_HD static constexpr uint32_t values_of(uint32_t features) { return kMoments + features + 2; }
  SplatMoments<F32> moments;
  F32 features[kMaxFeatures], weight, error;

  VITRINE_HD void clear() {
    moments = {};
    for (F32& f : features) f = 0.f;
    weight = error = 0.f;
  }
  // visit(value, its place in memory)
  template <class Visit>
  VITRINE_HD void for_each(uint32_t feature_count, const Visit& visit) {
    SplatMoments<F32>& m = moments;
    F32* const all[] = {&m.num_u, &m.num_u_x, &m.num_u_y, &m.num_v,  &m.num_v_x, &m.num_v_y, &m.den,
                        &m.den_x, &m.den_y,   &m.disc_x,  &m.disc_y, &m.weight,  &m.z0};
    static_assert(sizeof all / sizeof all[0] == kMoments);
#ifdef __CUDA_ARCH__
#pragma unroll
#endif
    for (uint32_t k = 0; k < kMoments; ++k) visit(*all[k], k);
#ifdef __CUDA_ARCH__
#pragma unroll
#endif
    for (uint32_t c = 0; c < kMaxFeatures; ++c)
      if (c < feature_count) visit(features[c], kMoments + c);
    visit(weight, kMoments + feature_count);
    visit(error, kMoments + feature_count + 1);
  }
};

// 32 threads for each instance: thread k adds up pixels k, k + 32, ... of the tile, then a thread for each value adds up the 32.
template <int kFeatures>
struct InstanceReverseKernel {
  static constexpr uint32_t kThreads = 128, kLanes = 32, kOfBlock = kThreads / kLanes;
  static constexpr uint32_t kValues = InstanceSums::values_of(kFeatures);
  static_assert(kValues <= kLanes);
  struct Shared {
    float sums[kOfBlock][kValues][kLanes + 1];  // a lane more: the threads of a phase then meet in no bank
  };
  using Thread = NoThread;
  BlockView view;
  SweptInstances instances;
  const uint64_t* keys;   // of the sorted instances
  const uint32_t* place;  // of each among those of all surfels, surfel by surfel
  InstanceFragments fragments;
  GradientPlanes in;
  float* out;  // [instances, kValues]
  uint32_t instance_count;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 2; }
  VITRINE_HD void run(uint32_t phase, Place at, Thread&, Shared& shared) const {
    const uint32_t of_block = at.thread / kLanes, lane = at.thread % kLanes, instance = at.block * kOfBlock + of_block;
    if (instance >= instance_count) return;
    if (phase == 0) {
      InstanceSums sums = sums_of(instance, lane);
      sums.for_each(kFeatures, [&](const F32& value, uint32_t k) { shared.sums[of_block][k][lane] = value.v; });
    } else if (lane < kValues) {
      F32 sum = 0.f;
      for (uint32_t k = 0; k < kLanes; ++k) sum += F32(shared.sums[of_block][lane][k]);
      out[size_t{kValues} * place[instance] + lane] = sum.v;
    }
  }
  VITRINE_HD InstanceSums sums_of(uint32_t instance, uint32_t lane) const {
    constexpr uint32_t kSide = BlockView::kTileSide;
    InstanceSums sums;
    sums.clear();
    const SurfelRecord& record = instances.record(instance);
    const uint32_t tile = static_cast<uint32_t>(keys[instance] >> InstanceKey::kTileAt),
                   across = static_cast<uint32_t>(view.tiles_x);
    const uint32_t corner = tile / across * kSide * static_cast<uint32_t>(view.width) + tile % across * kSide;
    uint32_t next = fragments.offsets[instance];
    for (uint32_t word = 0; word < PixelMasks::kWords; ++word) {
      const uint32_t mask = fragments.masks.of(instance)[word], bit = 1u << lane, place_in_tile = word * kLanes + lane;
      const uint32_t at = next + bit_count(mask & (bit - 1));
      next += bit_count(mask);
      if ((mask & bit) == 0) continue;
      const uint32_t pixel = corner + place_in_tile / kSide * static_cast<uint32_t>(view.width) + place_in_tile % kSide;
      const InstanceFragments::Values values = fragments.values[at];
      const SplatSample<F32> f = sample_of(record, pixel, view);
      const F32 w = blend_weight(f.alpha, F32(values.transmittance));
      sums.moments.add(splat_sample_vjp(f, F32(values.grad_alpha), F32(values.grad_z)), f.dx, f.dy);
      for (int c = 0; c < kFeatures; ++c) sums.features[c] += w * in.at(in.features[c], pixel);
      sums.weight += w;
      sums.error += w * in.at(in.error, pixel);
    }
    return sums;
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
  const float* sums;  // of InstanceReverseKernel, for so many channels
  uint32_t features;
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
    const uint32_t values = InstanceSums::values_of(features);
    for (uint32_t k = begin; k < end; ++k)
      sum.for_each(features, [&](F32& to, uint32_t value) { to += F32(sums[size_t{values} * k + value]); });
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
