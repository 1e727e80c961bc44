// Stage `sfm`: photos -> calibrated, undistorted views in a normalised frame with sparse points (README.md).
//   reads   ingest (photos.json, linear EXRs, 8-bit copies); optionally given poses, and the user's masks
//   writes  images/ linear/ sparse/0 transforms.json scene.json sfm/gains.json sfm/lenses.json sfm/report.json
//   sfm/evidence/matches.png
//           sfm/passes.json where an object was moved between passes of photos; sfm/rigs.json with panoramas and cut fisheye
//           photos
#pragma once

#include <string>

#include "stages/sfm/feature_masks.h"
#include "stages/sfm/normalize.h"
#include "stages/stage.h"

namespace vitrine {

// Where the lens's axis meets the picture. Auto: in the middle, or elsewhere if the photos then fit clearly better.
enum class PrincipalPoint { Auto, Middle };

struct SfmConfig {
  int max_image_size = 1600;
  int max_features = 8192;
  std::string camera_model = "SIMPLE_RADIAL";
  PrincipalPoint principal_point = PrincipalPoint::Auto;
  int exhaustive_limit = 80;
  int retries = 2;
  double min_registered = 0.6;
  int seed = 0;
  UpMethod up = UpMethod::Auto;
  double pose_scale = 0;
  Turntable turntable = Turntable::Auto;
  FeatureMasksConfig masks;
};

void describe(Describer& d, SfmConfig& c);

Stage sfm_stage();
StageCost sfm_cost(const CostTerms& terms);
StageReport sfm_report();

}  // namespace vitrine
