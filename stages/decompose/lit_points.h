// Surface points with outgoing radiance, at which irradiance is solved before it is spread to the surfels: pixels of the rendered
// diffuse layer, merged by voxel over all training views.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

struct LitPoint {
  Vec3f position{}, normal{};  // unit, towards the cameras that see it
  Vec3f radiance{};            // mean over the views, linear, of the diffuse layer
  float specular_weight = 0, transmission = 0;
  float weight = 0;    // merged pixels, weighted by cosine
  float masked = 0;    // share of the pixels inside glass or mirror masks
  bool inner = false;  // inside the box of the mesh
};

struct LitPointsDesc {
  Bounds3 inner;            // the mesh's box: fine voxels inside, coarse ones outside
  double voxel = 0.01;      // scene units
  double outer_factor = 6;  // size ratio of the outer voxels
  int max_side = 320;       // of the rendered pictures, pixels
  float near_z = 0.01f;     // of the trained scene
  // From the centre of the box: farther content is light, not a surface.
  float sky_distance = std::numeric_limits<float>::max();
  float min_alpha = 0.5f;
  float min_cosine = 0.1f;  // grazing pixels are unreliable
  // One channel of the given size, above 1/2 on glass and mirrors; empty: no masks.
  std::function<ImageF(const View&, const Intrinsics&)> masked = {};
};

// The order depends only on the views. `progress` receives a fraction and may throw.
std::vector<LitPoint> lit_points(const SplatLayer& layer, const std::vector<View>& views, const LitPointsDesc& desc,
                                 const std::function<void(double)>& progress);

}  // namespace vitrine
