// One training run as a state machine: step() looks at one photo. The whole state can be saved and loaded; what happens in a
// step depends on that state, the options and the photos alone.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/model/image_model.h"
#include "core/optim/adam.h"
#include "core/optim/archive.h"
#include "stages/optimize/capture.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// Sums over one pass through all training photos.
struct EpochRecord {
  uint64_t step = 0;  // at its end
  uint64_t surfels = 0;
  double loss = 0, l1 = 0;  // means
};

struct TrainCounts {
  uint64_t skipped_gradients = 0, relocated = 0, added = 0, removed = 0;
};

class Trainer {
 public:
  // `config` and `capture` must outlive the trainer.
  Trainer(const OptimizeConfig& config, const Capture& capture, size_t max_surfels, SplatLayer initial);

  // Throws Error{Diverged} when the loss or too many gradients are not finite.
  void step();
  bool finished() const { return step_ >= static_cast<uint64_t>(config_.iterations); }
  uint64_t step_index() const { return step_; }
  double recent_loss() const { return recent_loss_; }  // smoothed over about 50 steps
  const SplatScene& scene() const { return scene_; }
  const std::vector<EpochRecord>& epochs() const { return epochs_; }
  const TrainCounts& counts() const { return counts_; }

  // Renders one photo's view at full size (frame.srgb is what the photo should show).
  void picture(uint32_t photo, Frame& frame) const;

  void save(ArchiveWriter& out) const;
  void load(ArchiveReader& in);

 private:
  double fraction() const { return double(step_) / config_.iterations; }
  size_t level() const;
  uint32_t photo_of_step();
  double descend(const PhotoLevel& photo);
  void move_surfels();
  void record(double loss, double l1);

  const OptimizeConfig& config_;
  const Capture& capture_;
  size_t max_surfels_;
  ImageModel model_;
  DiffusePass* diffuse_pass_;  // owned by model_

  SplatScene scene_, grad_;
  Adam adam_;
  SurfelAccumulator accumulator_;
  uint64_t step_ = 0;
  uint32_t bad_streak_ = 0;  // steps in a row with many broken gradients
  double recent_loss_ = 0;
  EpochRecord epoch_;  // being summed
  std::vector<EpochRecord> epochs_;
  TrainCounts counts_;

  Frame frame_;
  std::vector<float> target_;
  std::vector<uint8_t> active_;
  std::vector<uint32_t> order_;  // photos of one epoch, in turn
  uint64_t order_epoch_ = ~uint64_t(0);
};

}  // namespace vitrine
