#include "core/render/model/traced_passes.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"

namespace vitrine {

namespace {

constexpr uint64_t kLobeStream = 0x5f02;
constexpr size_t kReflectionGrain = 512;
// Steps of the R2 sequence (Roberts 2018): inverse powers of the root of x^3 = x + 1. Consecutive points fill the square
// evenly, so that few rays of a pixel, over samples and over steps, cover its lobe.
constexpr double kR2[] = {0.7548776662466927, 0.5698402909980532};

float fraction(double x) { return static_cast<float>(x - std::floor(x)); }

GlossyRay<float> mirror_ray(const Vec3f& view, const SurfacePoint<float>& p) {
  GlossyRay<float> ray;
  ray.half = p.normal;
  ray.direction = reflected(view, p.normal);
  ray.weight = 1;
  return ray;
}

// True if the panes' reflections show only the scene, so that the reflection layer is not needed.
bool mirrored_already(const Frame& frame, size_t group) {
  constexpr float kClosed = 1 / 255.f;
  const PaneImages& panes = frame.panes;
  if (panes.empty()) return false;
  const ShadedPixels& s = frame.shaded;
  for (uint32_t i = s.begin[group]; i < s.begin[group + 1]; ++i) {
    const uint32_t pixel = s.pixels[i];
    const float open = std::max(panes.near_open[pixel], panes.far_share[pixel] * panes.far_open[pixel]);
    if (!panes.shown[pixel] || open > kClosed) return false;
  }
  return true;
}

TraceDesc trace_desc(const ReflectionOptions& o, const SplatLayer& layer) {
  return {.sh_degree = std::min(o.sh_degree, layer.sh_degree()), .min_transmittance = o.min_transmittance};
}

}  // namespace

// Emits samples [first_sample, last_sample) of every group; a mirror ray is the first sample.
void ReflectionPass::emit(Frame& frame, int first_sample, int last_sample) {
  const ShadedPixels& s = frame.shaded;
  SecondaryRays& r = frame.reflection;
  const ReflectionOptions& options = frame.options.reflection;
  const uint64_t draw = mix64(frame.seed, kLobeStream);
  const int samples = std::max(options.samples, 1);
  chunks_.resize(chunk_count(s.groups(), kReflectionGrain));
  parallel_chunks(s.groups(), kReflectionGrain, [&](size_t chunk, size_t first, size_t last) {
    auto& out = chunks_[chunk];
    out.clear();
    for (size_t g = first; g < last; ++g) {
      if (!s.requested(g).reflection || mirrored_already(frame, g)) continue;
      const SurfacePoint<float>& p = s.points[g];
      const Vec3f view = s.rays[g].view;
      const auto group = static_cast<uint32_t>(g);
      if (options.lobe != Lobe::Sampled || p.roughness < options.mirror_below) {
        if (first_sample == 0) out.push_back({.group = group, .share = 1, .lobe = mirror_ray(view, p)});
        continue;
      }
      Rng rng(draw, s.chosen_pixel(g));
      const double start[] = {rng.uniform_double(), rng.uniform_double()};
      for (int i = first_sample; i < last_sample; ++i) {
        const double at = double(frame.step) * samples + i;
        const Vec3f half = ggx_half_vector(p.normal, p.roughness * p.roughness, fraction(start[0] + at * kR2[0]),
                                           fraction(start[1] + at * kR2[1]));
        const GlossyRay<float> ray = glossy_ray(view, p.normal, half, p.roughness);
        if (ray.weight > 0) out.push_back({.group = group, .share = 1.f / float(samples), .lobe = ray});
      }
    }
  });
  r.gather(s.groups(), chunks_);
  parallel_chunks(r.rays.size(), kReflectionGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const SurfacePoint<float>& p = s.points[r.rays[i].group];
      r.origins[i] = p.position;
      r.directions[i] = r.rays[i].lobe.direction;
      r.near[i] = options.near;
    }
  });
}

void ReflectionPass::forward(const SplatScene& scene, Frame& frame) {
  frame.reflection.clear();
  if (scene.reflection.size() == 0 || frame.shaded.groups() == 0) return;
  const ReflectionOptions& options = frame.options.reflection;
  tracer_->build(scene.reflection);
  SecondaryRays& r = frame.reflection;
  const TraceDesc desc = trace_desc(options, scene.reflection);
  const int samples = options.lobe == Lobe::Sampled ? std::max(options.samples, 1) : 1;
  // Only gradients need all samples at once: 64 of them for a large picture are gigabytes.
  const int at_once = frame.differentiable ? samples : 1;
  sum_.clear();
  for (int i = 0; i < samples; i += at_once) {
    emit(frame, i, i + at_once);
    r.trace(*tracer_, desc, frame.shaded, frame.differentiable);
    if (at_once == samples) return;
    sum_.resize(r.radiance.size());
    for (size_t g = 0; g < sum_.size(); ++g) sum_[g] += r.radiance[g];
  }
  r.radiance = sum_;
}

void ReflectionPass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  SecondaryRays& r = frame.reflection;
  ShadedPixels& s = frame.shaded;
  if (r.rays.empty()) return;
  r.trace_back(*tracer_, trace_desc(frame.options.reflection, scene.reflection), s, frame.error_image, grad.reflection,
               &ray_gradients_);
  // Rays of a group are adjacent, and a group's point belongs only to it: no data race.
  parallel_chunks(s.groups(), kReflectionGrain, [&](size_t, size_t first, size_t last) {
    for (size_t g = first; g < last; ++g)
      for (uint32_t i = r.begin[g]; i < r.begin[g + 1]; ++i) {
        const SurfacePoint<float>& p = s.points[g];
        const GlossyRay<float>& ray = r.rays[i].lobe;
        SurfacePoint<float>& out = s.grad_points[g];
        out.position += ray_gradients_.origins[i];
        if (ray.alpha > 0) {  // sampled
          const float grad_weight = r.rays[i].share * dot(r.grad_radiance[g], r.values.color[i]);
          const GlossyGrad<float> back =
              glossy_ray_vjp(s.rays[g].view, p.normal, p.roughness, ray, ray_gradients_.directions[i], grad_weight);
          out.normal += back.normal;
          out.roughness += back.roughness;
          continue;
        }
        out.normal += carried_vjp(p.normal, p.normal, reflected_vjp(s.rays[g].view, p.normal, ray_gradients_.directions[i]));
      }
  });
}

namespace {

constexpr size_t kTransmissionGrain = 512;

TraceDesc trace_desc(const TransmissionOptions& o, const SplatLayer& layer) {
  return {.sh_degree = std::min(o.sh_degree, layer.sh_degree()), .min_transmittance = o.min_transmittance};
}

}  // namespace

void TransmissionPass::forward(const SplatScene& scene, Frame& frame) {
  SecondaryRays& r = frame.transmission;
  const ShadedPixels& s = frame.shaded;
  const TransmissionOptions& options = frame.options.transmission;
  r.clear();
  if (options.glass != Glass::Traced || scene.transmittance.size() == 0 || s.groups() == 0) return;
  tracer_->build(scene.transmittance);
  rays_.clear();
  for (size_t g = 0; g < s.groups(); ++g) {
    if (!s.requested(g).transmission) continue;
    SecondaryRay ray;
    ray.group = static_cast<uint32_t>(g);
    ray.lobe.direction = -s.rays[g].view;
    ray.lobe.weight = 1;
    rays_.push_back(ray);
  }
  r.gather(s.groups(), std::span(&rays_, 1));
  parallel_chunks(r.rays.size(), kTransmissionGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      r.origins[i] = s.points[r.rays[i].group].position;
      r.directions[i] = r.rays[i].lobe.direction;
      r.near[i] = options.near;
    }
  });
  r.trace(*tracer_, trace_desc(options, scene.transmittance), s, frame.differentiable);
}

void TransmissionPass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  if (frame.transmission.rays.empty()) return;
  frame.transmission.trace_back(*tracer_, trace_desc(frame.options.transmission, scene.transmittance), frame.shaded,
                                frame.error_image, grad.transmittance, nullptr);
}

}  // namespace vitrine
