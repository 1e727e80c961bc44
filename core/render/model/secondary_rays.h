// Secondary rays: the pixels that request them, and the rays of one layer (reflection or transmittance) with their results.
// Passes write them; the composite and the first-hit losses read them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/render/model/kernels/ggx.h"
#include "core/render/model/kernels/layer_blend.h"
#include "core/render/model/kernels/surface_point.h"
#include "core/render/trace/tracer.h"

namespace vitrine {

// Pixels that reflect or transmit, in groups of neighbours. One pixel of a group sends the rays for the whole group and
// represents it in the gradient; without a budget every group is one pixel.
struct ShadedPixels {
  // Per pixel, sorted by group.
  std::vector<uint32_t> pixels;
  std::vector<LayersPresent> requests;  // layers requested by the pixel
  // Per group.
  std::vector<uint32_t> begin;                           // [groups + 1] into pixels and requests
  std::vector<uint32_t> chosen;                          // index into pixels and requests of the pixel that sends the rays
  std::vector<PixelRay<float>> rays;                     // of the chosen pixel
  std::vector<SurfacePoint<float>> points, grad_points;  // of the chosen pixel
  size_t groups() const { return chosen.size(); }
  uint32_t chosen_pixel(size_t group) const { return pixels[chosen[group]]; }
  LayersPresent requested(size_t group) const { return requests[chosen[group]]; }
  // Number of pixels of the group: the inverse of the probability of the chosen pixel.
  float weight(size_t group) const { return static_cast<float>(begin[group + 1] - begin[group]); }
  void clear();
};

// One ray of a group: its direction and weight, and its share of the group's radiance.
struct SecondaryRay {
  uint32_t group = 0;
  float share = 1;  // 1 / samples
  GlossyRay<float> lobe;
};

struct SecondaryRays {
  // Per ray.
  std::vector<SecondaryRay> rays;
  std::vector<Vec3f> origins, directions;
  std::vector<float> near;
  RayValues values;
  std::vector<float> mean_distance, alpha;  // sum w t / sum w (0: no hit), sum w
  std::vector<float> weight;                // number of pixels that a ray represents in a loss over rays
  RayValues gradients;                      // losses add to gradients.first_hit (sized and zeroed by the forward pass)
  HitLists hits;
  // Per group: radiance arriving at the surface, zero where the group sent no ray; empty while the layer is empty.
  std::vector<uint32_t> begin;  // [groups + 1] into the rays
  std::vector<Vec3f> radiance, grad_radiance;
  std::vector<float> inner_transmittance;  // of the layer, mean over the group's rays; 1 without a ray
  std::vector<float> picture_weight;       // weight of the radiance in the picture: mean over the channels (CompositePass)

  SurfelStatistics statistics;  // of the layer: sums over the backward of all passes that render its surfels
  bool took_part = false;       // whether any of these passes contributed to the last backward

  bool sent(size_t group) const { return !begin.empty() && begin[group + 1] > begin[group]; }
  // Clears the last picture, except picture_weight and the results of the last backward.
  void clear();
  // Steps of a tracing pass: gather the rays of consecutive chunks of groups (and size the arrays), trace them and sum per
  // group; in backward, propagate grad_radiance to the rays, and add to the layer's gradients and statistics.
  void gather(size_t groups, std::span<const std::vector<SecondaryRay>> rays_of);
  void trace(const Tracer& tracer, const TraceDesc& desc, const ShadedPixels& shaded, bool keep_hits);
  void trace_back(const Tracer& tracer, const TraceDesc& desc, const ShadedPixels& shaded, std::span<const float> error_image,
                  SplatLayer& grad, RayGradients* ray_gradients);
  RayBatch batch() const { return {.origins = origins, .directions = directions, .near = near, .far = {}}; }

 private:
  std::vector<float> ray_error_;  // [rays]
};

}  // namespace vitrine
