// Surface points with outgoing radiance, at which irradiance is solved before it is spread to the surfels: pixels of the rendered
// diffuse layer, merged by voxel over all training views.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"
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

// Albedo affinity: pairs of points that probably have the same albedo. Partners are neighbours of the same chromaticity, and
// points anywhere in the same chromaticity cluster (k-means). Light mainly changes brightness; paint changes brightness and
// chromaticity.

struct AffinityDesc {
  float radius = 0.1f;  // of the neighbourhood, scene units
  int clusters = 16;
  uint64_t seed = 1;
};

struct Affinity {
  struct Partner {
    uint32_t point;
    float weight;
  };
  std::vector<uint32_t> begin;  // [points + 1] into partners
  std::vector<Partner> partners;
  std::span<const Partner> of(size_t point) const { return {partners.data() + begin[point], begin[point + 1] - begin[point]}; }
};

Affinity affinity(std::span<const Vec3f> positions, std::span<const Vec3f> radiance, const AffinityDesc& desc);

// Interpolation of irradiance from points to surfels: nearest points on the same side of the surface, weighted by distance and
// angle.

struct SpreadDesc {
  float inner_radius = 0.01f, outer_radius = 0.06f;  // distance of neighbouring points
  size_t neighbours = 8;
};

// One per surfel. `usable[i]` = false: the point is ignored. Surfels far from every usable point get the mean of all.
std::vector<Vec3f> spread_irradiance(const SplatLayer& layer, const Bounds3& inner, std::span<const LitPoint> points,
                                     std::span<const Vec3f> irradiance, const std::vector<bool>& usable, const SpreadDesc& desc);

// View-independent colour of a surfel: the mean over the cameras in front of it.
std::vector<Vec3f> surfel_radiance(const SplatLayer& layer, std::span<const Vec3f> eyes);

}  // namespace vitrine
