// Ray tracer for one layer of surfels, forward and backward, with one virtual call per pass. It complements the rasteriser,
// which renders the pixels of a pinhole camera, with rays of any origin and direction (reflected, transmitted, shadow). Back
// ends: "embree" (single precision, threads), "reference" (double, O(rays x surfels), the executable specification) and "blocks"
// (for a GPU). Hits are composited in exact order of (t, surfel index). README.md in this folder derives the mathematics.
//
//   alpha_i = min(0.99, opacity exp(-(u^2+v^2)/2)), dropped below 1/255;  w_i = alpha_i T_i while T_i >= min_transmittance
//   color = sum w c(direction)   distance = sum w t   normal = sum w n   transmittance = product of (1 - alpha)
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/render/raster/renderer.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Views of the caller's arrays, which must live until the call returns. Spans with a stated default may be empty.
struct RayBatch {
  std::span<const Vec3f> origins;     // [n]
  std::span<const Vec3f> directions;  // [n], unit
  std::span<const float> near = {};   // [n], a hit counts if near < t <= far; empty: 0
  std::span<const float> far = {};    // [n]; empty: infinity
  size_t size() const { return origins.size(); }
};

struct TraceDesc {
  int sh_degree = 3;  // used for colour; at most the layer's
  // A hit is blended iff the transmittance in front of it is at least this; later hits add at most this much. The rasteriser's
  // value is 1e-4.
  float min_transmittance = 1e-3f;
  float first_hit_weight = 0.1f;  // the first hit is the one where the summed weight reaches this
};

// Per ray; resized by forward(). As a gradient, an empty vector counts as zero.
struct RayValues {
  std::vector<Vec3f> color;          // linear, without background: add transmittance * background
  std::vector<float> transmittance;  // behind the last blended hit; 1 - sum of weights
  std::vector<float> distance;       // sum of w t: divide by (1 - transmittance) for the mean
  std::vector<float> first_hit;      // t of the hit where the summed weight reaches first_hit_weight; 0 if it does not
  std::vector<Vec3f> normal;         // sum of w n, n facing the ray's origin; world space, not normalised
  void resize(size_t rays);
};

// Output of forward() for backward(): the blended hits of every ray, front to back. The tracer reorders rays and splits them
// into chunks. Reuse the object between steps to reuse its memory.
struct TraceHit {
  uint32_t surfel;
  float t;
  float alpha;
  Vec3f color;
};
struct HitLists {
  static constexpr size_t kChunk = 64;  // rays
  struct Chunk {
    std::vector<TraceHit> hits;
    std::vector<uint32_t> end;  // per ray of the chunk: one past its last hit
  };
  std::vector<Chunk> chunks;
  std::vector<uint32_t> ray_at, place_of;  // [n] ray by place, and place by ray
  std::span<const TraceHit> of(size_t ray) const;
  size_t size() const;  // hits of all rays
};

struct TraceBackwardInput {
  const RayValues* gradients = nullptr;  // dL/d(output of forward)
  std::span<const float> error = {};     // [n] or empty: per-ray error, distributed to the hit surfels
};

// Per ray; overwritten by backward(). `wanted` = false skips the computation.
struct RayGradients {
  std::vector<Vec3f> origins, directions;  // directions: as three free coordinates; project if they are normalised
};

class Tracer {
 public:
  virtual ~Tracer() = default;
  // Builds the acceleration structure of `layer`, which must outlive the calls below and not change before the next build().
  virtual void build(const SplatLayer& layer) = 0;
  // `hits` may be null if no backward pass follows.
  virtual void forward(const RayBatch& rays, const TraceDesc& desc, RayValues& out, HitLists* hits) const = 0;
  // Adds to `grad` (same shape as the layer, raw values) and, if given, to `statistics`; writes `ray_gradients` if given. Same
  // rays, desc and hits as forward(). Statistics: screen_gradient is the norm of the mean's gradient times t/2 (Xie et al.
  // 2025, "EnvGS"), which is the rasteriser's unit for a camera at the ray's origin.
  virtual void backward(const RayBatch& rays, const TraceDesc& desc, const HitLists& hits, const TraceBackwardInput& input,
                        SplatLayer& grad, RayGradients* ray_gradients, SurfelStatistics* statistics) const = 0;
  virtual std::string_view name() const = 0;
};

// Embree: on the device that use_device() chose (core/render/raster/device.h), if it chose one. Blocks: the kernels for a GPU as
// loops on the CPU; for tests. A tracer of these computes one pass at a time.
enum class TracerBackend : unsigned char { Reference, Embree, Blocks };
std::unique_ptr<Tracer> make_tracer(TracerBackend backend = TracerBackend::Embree);

}  // namespace vitrine
