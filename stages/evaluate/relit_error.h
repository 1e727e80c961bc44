// The scene under other lights against truth/relit/<name>/<stem>.exr, lit by truth/env/<name>.exr alone (algorithms 8.2). Albedo
// is known up to one factor per channel: with a truth albedo the albedo is multiplied by the factors that its own score found,
// else each environment's pictures get the median of truth / ours over the object; `scale_mode` says which. Both pictures go to
// sRGB, clipped, at the coarser of their sizes.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/render/relight/relit_painter.h"
#include "stages/evaluate/regions.h"
#include "stages/evaluate/truth.h"

namespace vitrine {

// What the relit pictures of one environment scored.
struct RelitScore {
  std::string environment;
  // The object outside the glass; the object with what glass shows of it; all pixels; all pixels.
  std::optional<double> psnr, with_glass_psnr, everywhere_psnr, ssim;
  std::map<std::string, double> region_psnr;  // of all regions but the object
  Vec3d scale{1, 1, 1};                       // of the pictures, where the albedo was not scaled
  size_t views = 0;                           // that show something of the truth
};

struct RelitErrorDesc {
  const Truth& truth;
  const std::vector<View>& views;  // in the order that the truth knows
  Similarity truth_from_ours;
  std::optional<Vec3d> albedo_scale;
  int samples = 32, max_views = 4;
  std::filesystem::path pictures;  // <name>/<stem>.png: truth and ours side by side; empty: none
};

// Regions of a view at a size.
using RelitRegions = std::function<RegionMasks(size_t view, const Intrinsics&)>;

// One score per environment that has pictures. `progress` gets a fraction.
std::vector<RelitScore> relit_scores(RelitScene scene, const RelitRegions& regions, const RelitErrorDesc& desc,
                                     const std::function<void(double)>& progress);
// Environments of the truth that have a map and pictures, by name.
std::vector<std::string> relit_environments(const Truth& truth);

}  // namespace vitrine
