// What leaves the surfaces that the diffuse layer shows: which pixels ask for rays, and the rays of one layer (reflection or
// transmittance) with what they met. Written by the passes, read by the composite and by the losses on first hits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/render/model/kernels/ggx.h"
#include "core/render/model/kernels/layer_blend.h"
#include "core/render/model/kernels/surface_point.h"
#include "core/render/trace/tracer.h"

namespace vitrine {

// Pixels that reflect or transmit, in groups of neighbours. One pixel of a group sends the rays of all and stands for it in the
// gradient; without a budget every group is one pixel.
struct ShadedPixels {
  // Per pixel, group after group.
  std::vector<uint32_t> pixels;
  std::vector<LayersPresent> asks;  // which layers the pixel wants to see
  // Per group.
  std::vector<uint32_t> begin;                           // [groups + 1] into the two above
  std::vector<uint32_t> chosen;                          // which entry of the two above sends the rays
  std::vector<PixelRay<float>> rays;                     // of the chosen pixel
  std::vector<SurfacePoint<float>> points, grad_points;  // likewise
  size_t groups() const { return chosen.size(); }
  uint32_t chosen_pixel(size_t group) const { return pixels[chosen[group]]; }
  LayersPresent asked(size_t group) const { return asks[chosen[group]]; }
  // How many pixels a group stands for: the inverse of the probability that the chosen one was chosen.
  float weight(size_t group) const { return static_cast<float>(begin[group + 1] - begin[group]); }
  void clear();
};

// One ray of a group: its direction and weight, and what share of the group's radiance it brings.
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
  std::vector<float> mean_distance, alpha;  // sum w t / sum w (0: met nothing), sum w
  std::vector<float> weight;                // pixels that a ray stands for in a loss over rays
  RayValues gradients;                      // losses add to gradients.first_hit (sized and zeroed by the forward pass)
  HitLists hits;
  // Per group: radiance that arrives at the surface, zero where the group sent no ray; empty while the layer is.
  std::vector<uint32_t> begin;  // [groups + 1] into the rays
  std::vector<Vec3f> radiance, grad_radiance;
  std::vector<float> inner_transmittance;  // of the layer, mean over the group's rays; 1 without a ray
  std::vector<float> picture_weight;       // what the radiance counts in the picture: mean over the channels (CompositePass)

  SurfelStatistics statistics;  // of the layer: sums over all passes that show surfels of it, in reverse
  bool took_part = false;       // whether any of these passes had something to do in the last reverse

  bool sent(size_t group) const { return !begin.empty() && begin[group + 1] > begin[group]; }
  // Forgets the last picture, but for picture_weight and what the last reverse left.
  void clear();
  // The steps of a pass that traces: take the rays of consecutive chunks of groups (and size the arrays that the pass
  // fills), trace and sum up per group; in reverse from grad_radiance to the rays, and added to the layer and its statistics.
  void gather(size_t groups, std::span<const std::vector<SecondaryRay>> rays_of);
  void trace(const Tracer& tracer, const TraceDesc& desc, const ShadedPixels& shaded, bool keep_hits);
  void trace_back(const Tracer& tracer, const TraceDesc& desc, const ShadedPixels& shaded, std::span<const float> error_image,
                  SplatLayer& grad, RayGradients* ray_gradients);
  RayBatch batch() const { return {.origins = origins, .directions = directions, .near = near, .far = {}}; }

 private:
  std::vector<float> blame_;  // [rays]
};

}  // namespace vitrine
