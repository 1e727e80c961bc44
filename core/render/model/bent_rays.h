// What thick glass shows: in its pixels the straight view of ThinGlassPass gives way to rays through the same surfels, leg by leg
// along the bent path (ThickGlass):
//   C_t = sum_k P_k C_k    P_k = product of the T_j of the legs j < k
// Gradients reach the surfels that the legs meet; the path itself counts as fixed, as the ends of straight segments do. Pixels
// whose path is not bent (total reflection, a hole) keep the straight view.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/render/model/frame.h"
#include "core/render/model/image_options.h"
#include "core/render/model/thick_glass.h"

namespace vitrine {

// The ways of many rays through thick glass, leg by leg.
struct BentLegs {
  std::vector<uint32_t> pixels, begin;  // of the bent rays, and [pixels + 1] their legs
  std::vector<Vec3f> origins, directions;
  std::vector<float> far;
  std::vector<float> passed;  // what the wall lets pass of the leg's light; 1 where the picture's own Fresnel term has all walls

  // Of the pixels `asking` of a frame with its diffuse pass. Writes how their rays go to `path`, [h,w]. `side` x `side` rays a
  // pixel, of which those that are bent stand one after the other.
  void find(const ThickGlass& glass, const Frame& frame, std::span<const uint32_t> asking, std::span<GlassPath> path,
            int side = 1);
  RayBatch batch() const { return {.origins = origins, .directions = directions, .far = far}; }

  struct Shown {
    Vec3f color{};            // C_t
    float transmittance = 1;  // left for what stands behind everything that the last leg meets
  };
  // `values`: of batch().
  Shown shown(size_t bent_pixel, const RayValues& values) const;
};

class BentRays {
 public:
  bool any() const { return !legs_.pixels.empty(); }  // of the last forward()
  // `opened`: the scene without its glass, as frame.behind shows it. Writes radiance and inner_transmittance of bent pixels and
  // frame.behind.path.
  void forward(const TransmissionOptions& options, const SplatLayer& opened, Frame& frame);
  // Takes the gradients (and the blame, [h,w] or empty) of bent pixels away from the straight view: adds to `grad`, of the shape
  // of `opened`, and to `statistics`.
  void backward(Frame& frame, std::span<float> blame, SplatLayer& grad, SurfelStatistics& statistics);

 private:
  std::unique_ptr<Tracer> tracer_;
  TraceDesc desc_;
  BentLegs legs_;
  std::vector<uint32_t> asking_;
  std::vector<float> blame_;
  RayValues values_, gradients_;
  HitLists hits_;
};

}  // namespace vitrine
