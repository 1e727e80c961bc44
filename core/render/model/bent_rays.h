// Refracted view through thick glass: replaces the straight view of ThinGlassPass by rays through the same surfels, traced
// segment by segment along the refracted path (ThickGlass):
//   C_t = sum_k P_k C_k    P_k = product of the T_j of the segments j < k
// Gradients reach the surfels that the segments hit; the path itself is constant, as are the endpoints of straight segments.
// Pixels without a refracted path (total reflection, a hole in the mesh) keep the straight view.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/render/model/frame.h"
#include "core/render/model/image_options.h"
#include "core/render/model/thick_glass.h"

namespace vitrine {

// Refracted paths of many rays through thick glass, as segments.
struct BentLegs {
  std::vector<uint32_t> pixels, begin;  // begin: [pixels + 1] index of the first segment of each refracted ray
  std::vector<Vec3f> origins, directions;
  std::vector<float> far;
  std::vector<float> passed;  // transmittance of the glass wall; 1 where the picture's own Fresnel term covers all walls

  // Computes the paths of the pixels `asking` of a frame after its diffuse pass. Writes the kind of path to `path`, [h,w].
  // `side` x `side` rays per pixel; the refracted rays of a pixel are consecutive.
  void find(const ThickGlass& glass, const Frame& frame, std::span<const uint32_t> asking, std::span<GlassPath> path,
            int side = 1);
  RayBatch batch() const { return {.origins = origins, .directions = directions, .far = far}; }

  struct Shown {
    Vec3f color{};            // C_t
    float transmittance = 1;  // remaining behind everything that the last segment hits
  };
  // `values`: of batch().
  Shown shown(size_t bent_pixel, const RayValues& values) const;
};

class BentRays {
 public:
  bool any() const { return !legs_.pixels.empty(); }  // after the last forward()
  // `opened`: the scene without glass, as rendered in frame.behind. Writes radiance and inner_transmittance of pixels with
  // refracted paths, and frame.behind.path.
  void forward(const TransmissionOptions& options, const SplatLayer& opened, Frame& frame);
  // Moves the gradients (and `error_image`, [h,w] or empty, the source of per-surfel errors) of these pixels from the straight
  // view to the refracted rays: adds to `grad`, of the shape of `opened`, and to `statistics`.
  void backward(Frame& frame, std::span<float> error_image, SplatLayer& grad, SurfelStatistics& statistics);

 private:
  std::unique_ptr<Tracer> tracer_;
  TraceDesc desc_;
  BentLegs legs_;
  std::vector<uint32_t> requesting_;
  std::vector<float> ray_error_;
  RayValues values_, gradients_;
  HitLists hits_;
};

}  // namespace vitrine
