// Corrections of camera poses by the losses of pictures. A camera that moves sees what a fixed camera sees of a scene that moves
// the other way, so that the gradient of a pose is the sum of the gradients of the surfels; only the spherical harmonics of a
// surfel do not turn with it. Poses and scene can drift together without a change of any picture: hold_mean() fixes that.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/learn/optim/archive.h"
#include "core/scene/camera/view.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// By a turn (axis times radians) of the world about the centre of the camera, and a shift (scene units), both along its axes.
struct PoseGradient {
  Vec3d turn{}, shift{};
};
// `grad`: of the raw values of the layer, for a picture at this pose. Surfels whose gradient is not finite are left out.
PoseGradient pose_gradient(const SplatLayer& layer, const SplatLayer& grad, const Rigid& cam_from_world, int sh_degree);

// The pose after the world turned and shifted in front of the camera, along its axes; small turns.
Rigid moved_pose(const Rigid& cam_from_world, const Vec3d& turn, const Vec3d& shift);

struct PoseRates {
  double turn = 0, shift = 0;  // typical step: radians, scene units
};

// Distances of poses from others: root of the mean square and the largest, of angles and of the cameras' centres.
struct PoseDistance {
  double turn_rad = 0, shift = 0, largest_turn_rad = 0, largest_shift = 0;
};

// Adam (Kingma and Ba 2015) with a mean gradient a photo and two squares that all photos share, one of turns and one of shifts: a
// photo is visited too rarely for its own.
class PoseTraining {
 public:
  // `photos`: their cameras, with the given poses.
  explicit PoseTraining(std::vector<View> photos);
  const View& view(size_t photo) const { return now_[photo]; }  // stays at its place
  const Rigid& pose(size_t photo) const { return now_[photo].cam_from_world; }
  void set(size_t photo, const Rigid& pose) { now_[photo].cam_from_world = pose; }
  // Skipped if the gradient is not finite or zero.
  void descend(size_t photo, const PoseGradient& gradient, const PoseRates& rates);
  // Turns and shifts all poses so that those of `photos` are the given ones on the average.
  void hold_mean(std::span<const uint32_t> photos);
  void restart();                                              // forgets the moments, not the poses
  PoseDistance moved(std::span<const uint32_t> photos) const;  // from the given poses
  void transfer(Archive& archive);

 private:
  struct Moment {
    PoseGradient mean;
    uint64_t steps = 0;
  };
  std::vector<View> given_, now_;
  std::vector<Moment> moments_;  // [photo]
  double turn_square_ = 0, shift_square_ = 0;
  uint64_t steps_ = 0;
};

}  // namespace vitrine
