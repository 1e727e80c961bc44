// Embree tree of the surfels of a layer: user geometry with the exact bounds of every surfel's visible ellipse. gather()
// returns the hits of one ray; they do not depend on the shape of the tree.
#pragma once

#include <vector>

#include "core/foundation/base/plain_array.h"
#include "core/scene/surfels/layers.h"
#include "core/scene/mesh/embree_device.h"
#include "core/render/trace/embree/packed_colors.h"
#include "core/render/trace/embree/space_order.h"
#include "core/render/trace/kernels/ray_splat.h"
#include "core/render/trace/tracer.h"

struct RTCBoundsFunctionArguments;
struct RTCIntersectFunctionNArguments;

namespace vitrine::embree {

struct alignas(64) PackedSurfel : RaySurfel<float> {};

// A hit returned by gather().
struct FoundHit {
  float t;
  uint32_t surfel;
  float alpha;
  uint32_t place;  // in the arrays of the tree
};

class SurfelTree {
 public:
  void build(const SplatLayer& layer);
  // All hits of the ray that can be blended: sorted by (t, surfel), up to the one where the transmittance falls below
  // min_transmittance. `out` is reused.
  void gather(const TraceRay<float>& ray, float min_transmittance, std::vector<FoundHit>& out) const;

  std::span<const uint32_t> places() const { return order_.place_of; }  // by surfel
  uint32_t place_of(uint32_t surfel) const { return order_.place_of[surfel]; }
  uint32_t surfel_at(size_t place) const { return order_.surfel_at[place]; }
  const PackedSurfel& shape(size_t place) const { return surfels_[place]; }
  const PackedColors& colors() const { return colors_; }  // by place

 private:
  struct Gathering;
  static void bounds(const RTCBoundsFunctionArguments* args);
  static void intersect(const RTCIntersectFunctionNArguments* args);

  SpaceOrder order_;
  PlainArray<PackedSurfel, Pages::Huge> surfels_;
  PackedColors colors_;
  Scene scene_;
};

}  // namespace vitrine::embree
