// The kernels of the rasteriser in functions for a GPU, compiled but never run: device_usage_test.cpp bounds their registers.
// Loads and stores are as plain as can be, so that the registers are those of the mathematics.
#include "core/render/raster/kernels/blend.h"
#include "core/render/raster/kernels/project.h"
#include "core/render/raster/kernels/shade.h"
#include "core/render/raster/kernels/splat_weight.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

__device__ unsigned thread_index() { return blockIdx.x * blockDim.x + threadIdx.x; }

__global__ void project_surfels(const SurfelGeometry<float>* surfels, const float* opacity, Camera<float> camera, float near_z,
                                SplatConstants<float>* out, unsigned count) {
  const unsigned i = thread_index();
  if (i >= count) return;
  const Projection<float> p = project(surfels[i], camera);
  const float physical = sigmoid(opacity[i]);
  if (is_visible(p, physical, near_z)) out[i] = {p.map, physical, near_z / p.map.z0, float(kLowPassInvVariance)};
}

__global__ void project_surfels_vjp(const SurfelGeometry<float>* surfels, Camera<float> camera, const ScreenMap<float>* grad_map,
                                    const Vec3<float>* grad_normal, SurfelGeometry<float>* grad, unsigned count) {
  const unsigned i = thread_index();
  if (i >= count) return;
  const Projection<float> p = project(surfels[i], camera);
  grad[i] = project_vjp(surfels[i], camera, p, grad_map[i], grad_normal[i]).surfel;
}

__global__ void shade_surfels(const Vec3<float>* mean, Vec3<float> eye, const float* sh, Vec3<float>* colour, unsigned count) {
  const unsigned i = thread_index();
  if (i < count) colour[i] = sh_colour(3, mean[i], eye, sh + size_t(i) * 3 * kMaxShCoefficients).value;
}

__global__ void blend_pixels(const SplatConstants<float>* surfels, unsigned surfel_count, unsigned width, float* alpha,
                             float* zdepth, float* distortion) {
  const unsigned i = thread_index();
  const float px = float(i % width) + 0.5f, py = float(i / width) + 0.5f;
  float transmittance = 1, sum = 0, sum_z = 0;
  DistortionSums<float> sums;
  for (unsigned s = 0; s < surfel_count; ++s) {
    const SplatSample<float> f = splat_sample(surfels[s], px, py);
    const float w = blend_weight(f.alpha, transmittance);
    sum += w;
    sum_z += w * f.z;
    sums.add(w, reciprocal(f.z));
    transmittance *= 1 - f.alpha;
  }
  alpha[i] = sum;
  zdepth[i] = sum_z;
  distortion[i] = sums.value();
}

// One surfel for each thread, and all pixels of a row, back to front as given.
__global__ void blend_pixels_vjp(const SplatConstants<float>* surfels, const float* transmittance, const float* value,
                                 const float* grad_z, unsigned width, SplatGrad<float>* grad) {
  const unsigned i = thread_index();
  const SplatConstants<float> s = surfels[i];
  SplatMoments<float> moments;
  float behind = 0;
  for (unsigned x = 0; x < width; ++x) {
    const SplatSample<float> f = splat_sample(s, float(x) + 0.5f, 0.5f);
    const float grad_alpha = blend_vjp(transmittance[x], value[x], behind, reciprocal(1 - f.alpha));
    moments.add(splat_sample_vjp(f, grad_alpha, grad_z[x]), f.dx, f.dy);
    behind += f.alpha * value[x];
  }
  grad[i] = splat_grad(moments, s.map, s.opacity);
}

}  // namespace vitrine
