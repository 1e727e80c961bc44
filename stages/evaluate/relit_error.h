// Relighting error against truth/relit/<name>/<stem>.exr, lit only by truth/env/<name>.exr (algorithms 8.2). Albedo has one
// unknown factor per channel: with a truth albedo, ours is multiplied by the factors of its own score; otherwise the pictures of
// each environment are multiplied by the median of truth / ours over the object. `scale_mode` contains the choice. Both pictures
// are compared in sRGB, clipped, at the coarser of their sizes.
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

// Scores of the relit pictures of one environment.
struct RelitScore {
  std::string environment;
  // The object outside the glass; the object including its parts behind glass; all pixels; all pixels.
  std::optional<double> psnr, with_glass_psnr, everywhere_psnr, ssim;
  std::map<std::string, double> region_psnr;  // of all regions except the object
  Vec3d scale{1, 1, 1};                       // of the pictures, if the albedo was not scaled
  size_t views = 0;                           // with visible ground truth
};

struct RelitErrorDesc {
  const Truth& truth;
  const std::vector<View>& views;  // in the order of the truth
  Similarity truth_from_ours;
  std::optional<Vec3d> albedo_scale;
  int samples = 32, max_views = 4;
  std::filesystem::path pictures;  // <name>/<stem>.png: truth and ours side by side; empty: none
};

// Regions of a view at the given size.
using RelitRegions = std::function<RegionMasks(size_t view, const Intrinsics&)>;

// One score per environment with pictures. `progress` receives a fraction.
std::vector<RelitScore> relit_scores(RelitScene scene, const RelitRegions& regions, const RelitErrorDesc& desc,
                                     const std::function<void(double)>& progress);
// Environments of the truth that have a map and pictures, by name.
std::vector<std::string> relit_environments(const Truth& truth);

}  // namespace vitrine
