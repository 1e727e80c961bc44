// Stage `sfm`: photos -> calibrated, undistorted views in a normalised frame with sparse points (README.md).
//   reads   ingest (photos.json, linear EXRs, 8-bit copies); optionally given poses, and the user's masks
//   writes  images/ linear/ sparse/0 transforms.json scene.json sfm/gains.json sfm/lenses.json sfm/report.json
//   sfm/evidence/matches.png
//           sfm/passes.json where an object was moved between passes of photos
#pragma once

#include <string>

#include "stages/sfm/feature_masks.h"
#include "stages/stage.h"

namespace vitrine {

struct SfmConfig {
  int max_image_size = 1600;
  int max_features = 8192;
  std::string camera_model = "SIMPLE_RADIAL";
  std::string principal_point = "auto";
  int exhaustive_limit = 80;
  int retries = 2;
  double min_registered = 0.6;
  int seed = 0;
  std::string up = "auto";
  double pose_scale = 0;
  std::string turntable = "auto";
  FeatureMasksConfig masks;
};

void describe(Describer& d, SfmConfig& c);

Stage sfm_stage();
StageCost sfm_cost(const CostTerms& terms);
StageReport sfm_report();

}  // namespace vitrine
