// Cost estimate of the sfm stage.
#include <algorithm>
#include <cmath>

#include "stages/sfm/sfm.h"
#include "stages/training_cost.h"

namespace vitrine {

namespace {

// Features per megapixel grow with texture; orientations make up to 1.4 of each found.
double features_of(const CostTerms& t, double mpx) {
  return std::min(mpx * (1500 + 23000 * t.capture.texture), 1.4 * t.number("sfm.max_features"));
}

}  // namespace

StageCost sfm_cost(const CostTerms& t) {
  const double n = t.photos(), mpx = t.mpx(t.limited("sfm.max_image_size", ingested_side(t))), f = features_of(t, mpx);
  const double out = ingested_mpx(t), all = n * (n - 1) / 2;
  const double some = n * (t.number("sfm.window") + t.number("sfm.retrieved") + std::log2(std::max(n, 2.0)));
  const double pairs = n <= t.number("sfm.exhaustive_limit") ? all : std::min(all, some);
  constexpr double kMatchedShare = 0.8, kVerify = 0.033, kMatch = 0.014, kMatchFeatures = 4300;
  const double extract = n * (0.90 * mpx + 54e-6 * f);
  const double match = pairs * kMatch * (f / kMatchFeatures) * (f / kMatchFeatures);
  const double verify = pairs * kMatchedShare * kVerify;
  const double map = 4 + 66e-6 * n * f;
  const double undistort = 0.27 * out;
  const double total = extract + match + verify + map + undistort;
  return stage_cost(total, (total - map) / total, 45 + t.threads * 275 * mpx, 4.2 * out);
}

}  // namespace vitrine
