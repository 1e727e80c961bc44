// Depth maps of the user, brought to the undistorted photos and to the unit of the scene (core/intake/depth/depth_files.h).
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct GivenDepth {
  std::vector<ImageF> maps;  // [view] z-depth, [h,w,1], 0 = unknown; empty: the photo has none
  double units_per_metre = 0;
  double spread = 0;        // of the ratios to the sparse points, relative (robust standard deviation)
  size_t ratios = 0;        // sparse points seen in the maps
  size_t photos = 0;        // with a map that is used
  size_t other_scale = 0;   // maps left out: their own scale differs
  bool from_frame = false;  // the unit of the poses is the scale: too few points
};

// Reads the maps of all views. `sfm`: the artifact, for the lenses of the photos; `max_side`: longest side of the results.
// nullopt, with `notes`: the maps are no depths of this scene, which is no error, since a run can do without. Throws Error{Input}
// for files that are no depth maps or belong to other photos.
std::optional<GivenDepth> given_depth(const std::filesystem::path& depth, const std::filesystem::path& sfm, const ViewSet& set,
                                      int max_side, Notes& notes);

// The scale of depth maps from the sparse points: the median of z of a point / value of the map, in scene units.
struct DepthRatio {
  uint32_t view = 0;
  double z = 0, value = 0;
};
struct DepthScale {
  // Whether the values are depths. Of inverse depths the ratios spread more than the depths of the points themselves.
  bool plausible() const;
  double scale = 0, spread = 0;      // median; 1.4826 times the median absolute deviation of the logarithms
  double of_points = 0;              // the same spread of the points' depths
  std::vector<uint8_t> other_scale;  // [view] 1: the median of this map differs from that of all
};
// Empty below kFewestRatios.
inline constexpr size_t kFewestRatios = 30;
std::optional<DepthScale> depth_scale(std::span<const DepthRatio> ratios, size_t views);

}  // namespace vitrine
