// Parameters and output images of a raster pass. Planar images: channel c of pixel (x, y) is at [(c * h + y) * w + x].
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/render/raster/aovs.h"
#include "core/scene/camera/view.h"

namespace vitrine {

struct RasterDesc {
  Intrinsics intrinsics;
  Rigid cam_from_world;
  FeatureSet features = FeatureSet::Surface;
  int sh_degree = 3;                    // used for colour; at most the layer's
  float near_z = 0.01f, far_z = 100.f;  // scene units; near culls, both define the distortion's depth mapping
  Vec3f background{0, 0, 0};            // linear; blended behind the colour channels
  bool low_pass = true;                 // screen-space low-pass (algorithms 1.4); off only for comparison with the ray tracer
  bool distortion = false;              // compute the distortion channel
  // [h, w] or empty = all pixels. A pixel with value 0 gets the background as if there were no surfels, costs almost nothing (a
  // whole block of 4x4 nothing), propagates no gradient and is not in the statistics. Must outlive backward().
  std::span<const uint8_t> wanted = {};
};

// Whether a pass with `desc` fills this channel.
bool produces(const RasterDesc& desc, Aov aov);

// Programming error unless desc.wanted is empty or has the size of the picture.
void check_wanted(const RasterDesc& desc);

// One image per AOV produced by the desc; others are empty.
struct RasterImages {
  int width = 0, height = 0;
  std::array<std::vector<float>, kAovCount> planes;  // [width(aov) * h * w]
  std::span<float> plane(Aov a) { return planes[static_cast<size_t>(a)]; }
  std::span<const float> plane(Aov a) const { return planes[static_cast<size_t>(a)]; }
  // Sizes the planes for `desc`; values are unspecified (zero when new).
  void resize(const RasterDesc& desc);
  // Also sets all values to zero.
  void reset(const RasterDesc& desc);
};

// Surface depth of a pixel from its channels. The mean depth is smoother than the median, but at an edge it lies between two
// surfaces: if they differ by more than 1 %, the median is used.

// `zdepth`: sum of w z; `alpha` > 0: sum of w; `median`: 0 if undefined.
inline float surface_depth(float zdepth, float alpha, float median) {
  constexpr float kMeanNearMedian_rel = 0.01f;
  const float mean = zdepth / alpha;
  return median > 0 && std::abs(mean - median) > kMeanNearMedian_rel * median ? median : mean;
}

}  // namespace vitrine
