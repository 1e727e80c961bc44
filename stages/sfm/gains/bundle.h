// Bundle adjustment in this process (Ceres, Huber loss at one pixel, one thread): what COLMAP's mapper keeps fixed can be freed.
#pragma once

#include <memory>
#include <vector>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

inline constexpr int kBundleSteps = 30;  // most steps of an adjustment

// True for lens models up to OPENCV.
bool bundle_supports(const ColmapModel& model);

// Number of focal lengths of a supported lens model: 1, or 2 (one for each axis).
size_t focal_count(const ColmapCamera& camera);

// Poses, points, focal lengths and distortion of `model` are adjusted in place, from its present values; every lens must be
// supported. Single-threaded: same result on every machine of an instruction set.
class BundleAdjustment {
 public:
  // Which focal lengths there are: one set for each camera, or one for each photo (the distortion stays that of the camera).
  enum class Focals { OfCameras, OfPhotos };

  explicit BundleAdjustment(ColmapModel& model, Focals focals = Focals::OfCameras);
  ~BundleAdjustment();
  BundleAdjustment(const BundleAdjustment&) = delete;
  BundleAdjustment& operator=(const BundleAdjustment&) = delete;

  size_t observations() const;
  // Root mean square error (pixels, of the Huber loss) as the model stands.
  double error();
  // The same after at most `steps` steps; infinite if the solver fails.
  double solve(bool principal_points, int steps = kBundleSteps);
  // First focal length of each photo of the model, in its order; 0: it has no observation.
  std::vector<double> focals() const;
  // Stores what the solver does not hold in the model: rotations and errors of points. Not with Focals::OfPhotos.
  void finish();

 private:
  class Problem;
  std::unique_ptr<Problem> problem_;
};

}  // namespace vitrine
