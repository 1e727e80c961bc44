// The multi-view vote: where in space is what the views disagree about? A thing that mirrors, or lets through, changes every
// picture it stands in; a voxel inside it falls on disagreement in most views, a voxel of the wall behind it only in some. The
// voxels that stand out are grouped, filled, and projected back: a visual hull of the evidence.
#pragma once

#include <span>
#include <vector>

#include "core/config/describe.h"
#include "core/math/voxel_grid.h"
#include "stages/masks/proposed/view_dependence.h"

namespace vitrine {

struct HullVoteConfig {
  int grid = 96;
  double min_views = 0.8;
  double weak_sigma = 3.5, strong_sigma = 6;
  double min_deviation = 0.014;
  double max_typical = 0.01;
};
void describe(Describer& d, HullVoteConfig& c);

struct ProposedThing {
  size_t voxels = 0;
  double score = 0;        // mean over its voxels of the typical deviation there, sRGB units
  double see_through = 0;  // share of its pixels at which the fit sees something behind it
  double coverage = 0;     // mean share of a photo
  Vec3d centre{};
  bool transparent = false;
};

struct HullVote {
  VoxelGrid<float> score;  // NaN: too few views
  std::vector<int> thing;  // [voxel of score] index into things, or -1
  std::vector<ProposedThing> things;
  double typical = 0, weak = 0, strong = 0;  // of the scores: their median, and the two thresholds
  bool unsure = false;                       // the fit is too coarse, or too little of the scene was walked around
};

HullVote hull_vote(const HullVoteConfig& config, const MaskCapture& capture, const std::vector<SmallPhoto>& photos,
                   const QuickFit& fit, const std::vector<DeviationMap>& deviations);
// [h,w] index of the first thing along each pixel's ray that is not hidden by what the fit sees, or -1.
std::vector<int> projected_things(const HullVote& vote, const SmallPhoto& photo, const FittedView& fitted);

}  // namespace vitrine
