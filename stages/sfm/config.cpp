// Options of the sfm stage.
#include "core/config/describe.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

void describe(Describer& d, SfmFilterConfig& c) {
  d.option("max_error_px", c.max_error_px, "Largest mean reprojection error of a point, in pixels.").range(0.1, 100);
  d.option("min_angle_deg", c.min_angle_deg, "Smallest angle between two rays to a point, in degrees.").range(0, 45);
  d.option("min_views", c.min_views, "Fewest photos that see a point.").range(2, 100);
  d.option("outlier_sigma", c.outlier_sigma,
           "Points farther from their neighbours than this many deviations leave; 0 = keep all.")
      .range(0, 100);
}

void describe(Describer& d, SfmConfig& c) {
  d.option("max_image_size", c.max_image_size, "Longest side at which features are found; 0 = as ingested.").range(0, 20000);
  d.option("max_features", c.max_features, "Most features of a photo.").range(100, 100000);
  d.option("peak_threshold", c.peak_threshold, "SIFT contrast threshold; lower finds more and weaker features.")
      .range(0.0001, 0.1);
  d.option("camera_model", c.camera_model, "Lens model to solve for.")
      .choices({"SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV"});
  d.option("max_ratio", c.max_ratio, "A match's angle over that of the second best; lower is stricter.").range(0.1, 1);
  d.option("max_distance", c.max_distance, "Largest angle between two matching descriptors, in radians.").range(0.1, 1.6);
  d.option("min_matches", c.min_matches, "Pairs of photos with fewer matches are left out.").range(8, 1000);
  d.option("exhaustive_limit", c.exhaustive_limit, "Up to this many photos all pairs are compared.").range(0, 2000);
  d.option("window", c.window, "Above the limit: neighbours compared in name order.").range(1, 1000);
  d.option("retrieved", c.retrieved, "Above the limit: photos of similar appearance compared with each photo.").range(0, 1000);
  d.option("retries", c.retries, "Rungs of the retry ladder: 1 relaxes the mapper, 2 also finds more features.").range(0, 2);
  d.option("retry_below", c.retry_below, "Share of registered photos below which the ladder is climbed.").range(0, 1);
  d.option("min_registered", c.min_registered, "Share of photos that need a pose; fewer is an error.").range(0, 1);
  d.option("min_observations", c.min_observations,
           "A photo whose pose hangs on fewer points than this does not count (twice as many after a retry).")
      .range(3, 10000);
  d.option("seed", c.seed, "Seed of every random choice.").range(0, 2147483647);
  d.option("up", c.up, "Where up comes from: auto, level cameras, plane of the ring, mean camera up, or views straight down.")
      .choices({"auto", "level", "ring", "mean", "nadir"});
  d.option("principal_point", c.principal_point,
           "Where the lens's axis meets the picture: in its middle, or (auto) elsewhere if the photos then fit clearly better.")
      .choices({"auto", "middle"});
  d.option("pose_scale", c.pose_scale, "Scale of given projection matrices; 0 = found from their principal points.")
      .range(0, 100);
  d.option("jpeg_quality", c.jpeg_quality, "Quality of undistorted photos with JPEG names.").range(50, 100);
  d.option("turntable", c.turntable,
           "Does the object turn before a camera that stands still? Then features outside its masks are not used; auto: shown by "
           "matches that stand still around an object that moves.")
      .choices({"auto", "yes", "no"});
  d.group("masks", c.masks, "Which masks keep features out.");
  d.group("points", c.points, "Which triangulated points are kept.");
}

}  // namespace vitrine
