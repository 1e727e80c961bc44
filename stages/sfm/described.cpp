// Options, cost estimate and report figures of the sfm stage.
#include <algorithm>
#include <cmath>

#include "core/foundation/config/describe.h"
#include "stages/sfm/pairs.h"
#include "stages/sfm/sfm.h"
#include "stages/training_cost.h"

namespace vitrine {

namespace {

constexpr const char* kPoses = "Photos and poses";
constexpr double kFewestPoints = 100;  // minimum for reliable poses and a reliable error

// Features per megapixel grow with texture; orientations make up to 1.4 of each found.
double features_of(const CostTerms& t, double mpx) {
  return std::min(mpx * (1500 + 23000 * t.capture.texture), 1.4 * t.number("sfm.max_features"));
}

}  // namespace

void describe(Describer& d, SfmConfig& c) {
  d.option("max_image_size", c.max_image_size, "Longest side at which features are found; 0 = as ingested.").range(0, 20000);
  d.option("max_features", c.max_features, "Most features of a photo.").range(100, 100000);
  d.option("camera_model", c.camera_model, "Lens model to solve for; OPENCV_FISHEYE for fisheye photos.")
      .choices({"SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "OPENCV_FISHEYE"});
  d.option("exhaustive_limit", c.exhaustive_limit, "Up to this many photos all pairs are compared.").range(0, 2000);
  d.option("retries", c.retries, "Rungs of the retry ladder: 1 relaxes the mapper, 2 also finds more features.").range(0, 2);
  d.option("min_registered", c.min_registered, "Share of photos that need a pose; fewer is an error.").range(0, 1);
  d.option("seed", c.seed, "Seed of every random choice.").range(0, 2147483647);
  d.choice("up", c.up, kUpMethodWords,
           "Where up comes from: auto, level cameras, plane of the ring, mean camera up, or views straight down.");
  d.choice("principal_point", c.principal_point, {"auto", "middle"},
           "Where the lens's axis meets the picture: in its middle, or (auto) elsewhere if the photos then fit clearly better.");
  d.option("pose_scale", c.pose_scale, "Scale of given projection matrices; 0 = found from their principal points.")
      .range(0, 100);
  d.choice("turntable", c.turntable, kTurntableWords,
           "Does the object turn before a camera that stands still? Then features outside its masks are not used; auto: shown by "
           "matches that stand still around an object that moves.");
  d.group("masks", c.masks, "Which masks keep features out.");
}

StageCost sfm_cost(const CostTerms& t) {
  const double n = t.photos(), mpx = t.mpx(t.limited("sfm.max_image_size", ingested_side(t))), f = features_of(t, mpx);
  const double out = ingested_mpx(t), all = n * (n - 1) / 2;
  const double some = n * (PairRules{}.window + PairRules{}.retrieved + std::log2(std::max(n, 2.0)));
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

StageReport sfm_report() {
  StageReport report{.file = "sfm/report.json"};
  report.figures = {
      ReportFigure{kPoses, "registered", "Photos that found their place", "%", 0, 0.9, 0.6,
                   "Share of the photos whose camera position was found.",
                   "The others are not used at all: they share too little with their neighbours.", "registered"}
          .share("photo_count")
          .measured_on("points.kept", kFewestPoints, "points")
          .noted("{registered:0} of {photo_count:0}"),
      ReportFigure{kPoses, "one_object", "Photos that show the object in one place", "%", 0, 1, 0.95,
                   "Share of the photos in the largest pass, where the object was moved between passes that are not joined.",
                   "The object was moved between passes of photos, and the poses do not follow it.", "passes.share_of_largest"}
          .noted("{passes.text}"),
      ReportFigure{kPoses, "reprojection", "Reprojection error", "px", 2, 1.0, 1.5,
                   "How far the sparse points land from where they were seen, in pixels of the photos, mean.",
                   "Poses are soft: blur, a moving object, or a lens that the camera model does not fit.",
                   "mean_reprojection_error_px"}
          .measured_on("points.kept", kFewestPoints, "points", true),
      ReportFigure{kPoses, "observations", "Points seen per photo", "", 0, 300, 100,
                   "Sparse points that a photo sees, median over the photos.",
                   "Few points hold a pose: plain surfaces or little overlap.", "photos.*.observations"}
          .folded("median", "registered")};
  report.facts = {{kPoses, "{points.kept:n} sparse points"},
                  {kPoses, "{passes.text}; the object was moved between them"},
                  {kPoses, "{gps.text}"},
                  {kPoses, "focal lengths found by the matches: {focal_lengths.text}"}};
  return report;
}

}  // namespace vitrine
