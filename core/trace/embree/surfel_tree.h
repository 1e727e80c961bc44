// The surfels of a layer in the form that rays want them, in an Embree tree of user geometry with the exact bounds of every
// surfel's visible ellipse. gather() finds the hits of one ray; nothing about them depends on the shape of the tree.
#pragma once

#include <vector>

#include "core/scene/layers.h"
#include "core/trace/embree/embree_device.h"
#include "core/trace/kernels/ray_splat.h"
#include "core/trace/tracer.h"

namespace vitrine::embree {

struct alignas(64) PackedSurfel : RaySurfel<float> {};

// A hit as gather() finds it.
struct FoundHit {
  float t;
  uint32_t surfel;
  float alpha;
};

class SurfelTree {
 public:
  void build(const SplatLayer& layer, const TraceBuildDesc& desc);
  // All hits of the ray that can be blended: sorted by (t, surfel), ending where the transmittance has fallen below
  // min_transmittance. `out` is reused.
  void gather(const TraceRay<float>& ray, float min_transmittance, std::vector<FoundHit>& out) const;

  const PackedSurfel& surfel(uint32_t i) const { return surfels_[i]; }
  size_t size() const { return surfels_.size(); }

 private:
  static void bounds(const RTCBoundsFunctionArguments* args);
  static void intersect(const RTCIntersectFunctionNArguments* args);

  std::vector<PackedSurfel> surfels_;
  float max_footprint_ = 0.f;
  Scene scene_;
};

}  // namespace vitrine::embree
