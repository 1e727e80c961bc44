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

struct SfmFilterConfig {
  double max_error_px = 2.0;
  double min_angle_deg = 1.5;
  int min_views = 2;
  double outlier_sigma = 3.0;
};

struct SfmConfig {
  int max_image_size = 1600;
  int max_features = 8192;
  double peak_threshold = 0.02 / 3;
  std::string camera_model = "SIMPLE_RADIAL";
  std::string principal_point = "auto";
  double max_ratio = 0.8;
  double max_distance = 0.7;
  int min_matches = 15;
  int exhaustive_limit = 80;
  int window = 10;
  int retrieved = 20;
  int retries = 2;
  double retry_below = 0.8;
  double min_registered = 0.6;
  int min_observations = 40;
  int seed = 0;
  std::string up = "auto";
  double pose_scale = 0;
  int jpeg_quality = 97;
  std::string turntable = "auto";
  FeatureMasksConfig masks;
  SfmFilterConfig points;
};

void describe(Describer& d, SfmFilterConfig& c);
void describe(Describer& d, SfmConfig& c);

Stage sfm_stage();
StageCost sfm_cost(const CostTerms& terms);
StageReport sfm_report();

}  // namespace vitrine
