// Training loop shared by the stages: each step uses one photo and updates all surfels of the scene; the order of the photos is
// shuffled for every epoch. A stage derives from it, provides the plan of each step and acts between steps; this class handles
// photos, losses, statistics, checkpoints and the detection of divergence. A step depends only on the saved state, the options
// and the photos: an interrupted run ends with the same bytes.
//
// Where a device is chosen that makes training steps, those that its kernels know (device_plan.cpp) run there, and the surfels
// stay in its memory from one to the next (training_state.h).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/learn/loss/loss_set.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/frozen_surfels.h"
#include "core/learn/trainer/layer_training.h"
#include "core/learn/trainer/medium_training.h"
#include "core/learn/trainer/pose_training.h"
#include "core/learn/trainer/shape_training.h"
#include "core/learn/trainer/targets.h"
#include "core/learn/trainer/training_state.h"
#include "core/render/model/layered_model.h"

namespace vitrine {

inline constexpr double kSceneRadius = 1;  // the sfm stage scales the ring of cameras to it

// Parameters of one step.
struct StepPlan {
  double fraction = 1;  // of the run, for the weights of the losses
  size_t level = 0;     // of the photos' pyramids
  ImageOptions image = {};
  std::array<AttributeRates, kAllLayers.size()> rates{};  // [layer kind]
  float rarest = 1;                                       // LayerTraining::Descent
  // [photo] 1: its glass and mirrors have weight zero (held out for validation). Empty: all count.
  std::span<const uint8_t> withheld = {};
  size_t untrained = 0;             // surfels at the end of the diffuse layer that remain unchanged
  ShapeTraining* shapes = nullptr;  // if not null, trained at shape_rates
  ShapeRates shape_rates = {};
  MediumTraining* medium = nullptr;  // if not null, trained at medium_rate
  double medium_rate = 0;
  PoseRates pose_rates = {};                             // of the photo's pose; 0: it stays
  float specular_weight = 1;                             // of the picture losses on mirrors: specular, not transparent
  bool glass_sends_rays = true, coats_send_rays = true;  // the pixels of their masks send rays
  std::optional<float> glass_factor = {};                // freeze_glass
  const KnownSurface* known_mirrors = nullptr;           // freeze_mirrors, at mirror_factor
  float mirror_factor = 1;
  bool one_glass = false;  // share_glass
};

// Inputs of a training; everything must outlive it.
struct TrainingDesc {
  const Capture& capture;  // its training photos are used
  const Targets& targets;  // pixels outside object masks and inside ignore masks have weight 0
  const LossSet& losses;
  uint64_t steps = 0, seed = 1;
  std::string remedy;  // hint of Error{Diverged}
};

// Sums over one pass through all training photos.
struct EpochRecord {
  uint64_t step = 0;  // at its end
  uint64_t surfels = 0;
  double loss = 0, l1 = 0;  // means
};

class Training {
 public:
  Training(const TrainingDesc& desc, const ImageOptions& image, SplatScene start);
  virtual ~Training() = default;

  // Throws Error{Diverged} if the loss or too many gradients are not finite.
  void step();
  // Whether the state is worth saving: the last pictures contained surfels, gradients of the last step were finite, and so are
  // all but a few surfels.
  bool sound() const;
  bool finished() const { return step_ >= desc_.steps; }
  uint64_t step_index() const { return step_; }
  double fraction() const { return double(step_) / double(desc_.steps); }
  // Smoothed over about 50 steps. A device adds a step when the next one runs; at the end of the run none is missing, nor in
  // epochs().
  double recent_loss() const { return recent_loss_; }
  const SplatScene& scene() const { return state_.scene(); }
  size_t surfels(LayerKind kind) const { return state_.surfels(kind); }  // without a copy from the device
  const std::vector<EpochRecord>& epochs() const { return epochs_; }
  const TrainCounts& counts(LayerKind kind) const { return state_.counts(kind); }

  // Resumes from a checkpoint. False: there is none, or it is damaged (`damaged` gets the reason); the training is then unusable.
  bool resume(const std::filesystem::path& checkpoint, const std::function<void(const std::string& why)>& damaged);
  struct Run {
    std::filesystem::path checkpoint;
    int checkpoint_every = 0;          // steps; 0: only on interruption and at the end
    std::function<void()> after_step;  // before its checkpoint
    std::function<void()> after_checkpoint;
  };
  // Runs to the end. On interruption saves its state and throws.
  void run(const Run& run);

  const PoseTraining& poses() const { return poses_; }
  // Moves the camera of a photo, mostly one that is not trained on, to where the scene agrees with it; the scene stays.
  void align(uint32_t photo);

 protected:
  virtual StepPlan plan() = 0;  // of the next step; starts the phases that are due
  virtual void end_step() = 0;  // step_index() already counts the step
  // Serialises the whole state. Throws Error{Input} if the data read is invalid.
  virtual void transfer(Archive& archive);

  // To change surfels and what Adam knows of them: a device then takes both anew.
  SplatScene& scene_to_change() { return state_.scene_to_change(); }
  LayerTraining& training(LayerKind kind) { return state_.layer_to_change(kind); }
  // LayerTraining::move, where the layer is.
  void move(LayerKind kind, const DensifyConfig& config, const LayerTraining::Move& move);
  uint32_t pictures(LayerKind kind) const { return state_.pictures(kind); }  // LayerTraining::pictures
  bool has_opaque_twin() const { return state_.opaque_twin_surfels() > 0; }

  LayeredModel model_;
  PoseTraining poses_;  // of all photos

 private:
  double look(const StepPlan& plan, uint32_t photo);
  void step_on_device(const StepPlan& plan, uint32_t photo);
  void settle(const std::optional<blocks::StepReport>& report);
  void settle() { settle(state_.report()); }
  void check_loss(double loss, uint64_t step, const std::string& photo) const;
  struct Descended {
    DescentCounts worst;  // of a layer with many non-finite gradients
    bool broken = false, blank = false;
  };
  void check_descent(const Descended& done, uint64_t step, const std::string& photo);
  bool is_withheld(const StepPlan& plan, uint32_t photo) const { return !plan.withheld.empty() && plan.withheld[photo] != 0; }
  PoseGradient pose_gradient_of(const StepPlan& plan) const;  // after look()
  void weigh_pixels(float specular_weight, bool withheld);
  void choose_ray_pixels(const StepPlan& plan);
  double write_error_image();
  double learn(const StepPlan& plan, const View& view);
  void update(const StepPlan& plan);
  void record(uint64_t step, size_t surfels, double loss, double l1);

  TrainingDesc desc_;
  TrainingState state_;
  SplatScene grad_;
  uint64_t step_ = 0;
  uint32_t bad_streak_ = 0;  // consecutive steps with many non-finite gradients, or without a surfel
  bool broken_ = false;      // many non-finite gradients in the last step
  double recent_loss_ = 0;
  EpochRecord epoch_;  // running sums
  std::vector<EpochRecord> epochs_;

  // Of the last step on a device, whose report is not read yet.
  struct Unsettled {
    uint64_t step = 0;
    size_t surfels = 0;
    std::string photo;
  } unsettled_;

  View view_;      // of the photo
  double l1_ = 0;  // of its picture
  Frame frame_;
  std::vector<float> target_;  // [3,h,w] the photo, raised to the prediction where it is clipped
  TargetImages images_;
  std::vector<float> weight_;    // [h,w] of the picture losses; empty: one
  std::vector<float> reflects_;  // [h,w] pixels that send reflection rays
  std::vector<float> damping_;   // [diffuse surfels]
};

// Steps on a device (device_plan.cpp).

// Whether a device is chosen and its kernels know the step: the picture is that of one opaque layer, and all losses have kernels.
bool device_knows(const StepPlan& plan, const LossSet& losses, uint64_t step_index, const TrainingState& state);
// The step as the device takes it; `withheld`: the photo is (StepPlan::withheld).
blocks::StepDesc device_step(const StepPlan& plan, const LossSet& losses, const TrainingState& state, const View& view,
                             bool withheld);
blocks::StepPhoto device_photo(uint32_t photo, size_t level, const PhotoLevel& picture, const TargetLevel& targets);

}  // namespace vitrine
