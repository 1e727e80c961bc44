// One training run as a state machine: step() looks at one photo. The whole state can be saved and loaded; what happens in a
// step depends on that state, the options and the photos alone.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/model/layered_model.h"
#include "core/optim/archive.h"
#include "core/stereo/scene_planes.h"
#include "core/train/capture.h"
#include "core/train/known_surface.h"
#include "core/train/layer_training.h"
#include "core/train/shape_training.h"
#include "core/train/targets.h"
#include "stages/optimize/layer_init.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// Sums over one pass through all training photos.
struct EpochRecord {
  uint64_t step = 0;  // at its end
  uint64_t surfels = 0;
  double loss = 0, l1 = 0;  // means
};

// What a run is about; everything must outlive the trainer.
struct TrainerSetup {
  const OptimizeConfig& config;
  const Capture& capture;
  const Targets& targets;
  const ShapeSet& shapes;  // that the image formation draws (ObjectSet::drawn_shapes)
  const ShapeSet& glass;   // of all glass, visual hulls among them
  LayerChoice layers;
  size_t max_surfels;         // of all layers together
  bool object_alone = false;  // (surroundings.h)
};

class Trainer {
 public:
  // `planes`, `background`: the large planes of the scene and the distance of its sky, where what no photo shows is guessed
  // (plane_inpainting.h).
  Trainer(const TrainerSetup& setup, SplatLayer initial, std::vector<ScenePlane> planes, double background = 0);

  // Throws Error{Diverged} when the loss or too many gradients are not finite.
  void step();
  // What was learnt until now is worth keeping: the last pictures showed surfels, gradients of the last step were numbers, and so
  // are all but a few surfels.
  bool sound() const;
  bool finished() const { return step_ >= static_cast<uint64_t>(config().iterations); }
  uint64_t step_index() const { return step_; }
  double recent_loss() const { return recent_loss_; }  // smoothed over about 50 steps
  const SplatScene& scene() const { return scene_; }
  const std::vector<EpochRecord>& epochs() const { return epochs_; }
  const TrainCounts& counts(LayerKind kind) const { return training(kind).counts(); }
  const LayerChoice& layers() const { return setup_.layers; }
  size_t from_behind_glass() const { return from_behind_glass_; }  // surfels that went to the diffuse layer (plane_inpainting.h)
  size_t unseen_surfels() const { return unseen_surfels_; }        // for what no photo shows (plane_inpainting.h), beyond the cap
  size_t initial_surfels() const { return initial_surfels_; }      // that training started from
  static size_t cap(const TrainerSetup& setup, LayerKind kind);    // most surfels the layer may grow to
  size_t cap(LayerKind kind) const { return cap(setup_, kind); }

  // Renders one photo's view at full size (frame.srgb is what the photo should show), with all rays; `layers`: taken apart too.
  void picture(uint32_t photo, bool layers, Frame& frame) const;

  // Of the passes at this moment.
  ImageOptions image_options() const;

  // After the last step: glass that was trained without surfels gets those that other stages and programs read, and what is seen
  // through it alone becomes the transmittance layer. Pictures stay the same.
  void finish();

  void save(ArchiveWriter& out) const;
  void load(ArchiveReader& in);

 private:
  const OptimizeConfig& config() const { return setup_.config; }
  double fraction() const { return double(step_) / config().iterations; }
  PhaseClock clock() const { return {config().phases, setup_.layers, fraction()}; }
  LayerTraining& training(LayerKind kind) { return training_[static_cast<size_t>(kind)]; }
  const LayerTraining& training(LayerKind kind) const { return training_[static_cast<size_t>(kind)]; }
  size_t level() const;
  uint32_t photo_of_step();
  int sh_degree() const { return fraction() < config().sh_from ? 0 : config().sh_degree; }
  size_t diffuse_cap() const;
  void point_at_masks();
  LayerInitDesc init_desc() const;
  void begin_phases();
  void begin_sheets();
  void fill_unseen();
  void fill_beside_glass();
  double descend(uint32_t photo);
  double blame(const PhotoLevel& photo);
  void weigh_pixels(const PhaseClock& clock);
  void update(const PhaseClock& clock, const std::string& photo);
  void move_surfels();
  void record(double loss, double l1);

  TrainerSetup setup_;
  DensifyConfig densify_behind_glass_;
  LayeredModel model_;

  SplatScene scene_, grad_;
  std::vector<LayerTraining> training_;    // [layer kind]
  std::array<uint8_t, 3> begun_{1, 0, 0};  // [layer kind]
  std::vector<ScenePlane> planes_;
  double background_;
  ShapeTraining shapes_;      // that mirror, and sheets of glass
  KnownSurface known_gloss_;  // of what reflects
  uint8_t filled_ = 0;        // what no photo shows
  bool sheets_;               // glass is drawn from its shapes
  size_t glass_surfels_ = 0;  // that carry it, after finish(): the last ones of the diffuse layer
  uint64_t initial_surfels_ = 0, unseen_surfels_ = 0, from_behind_glass_ = 0;
  uint64_t step_ = 0;
  uint32_t bad_streak_ = 0;  // steps in a row with many broken gradients, or without a surfel
  bool broken_ = false;      // many broken gradients in the last step
  double recent_loss_ = 0;
  EpochRecord epoch_;  // being summed
  std::vector<EpochRecord> epochs_;

  Frame frame_;
  std::vector<float> target_;
  TargetImages target_images_;
  std::vector<float> weight_;    // [h,w] of the picture losses; empty: one
  std::vector<float> gloss_;     // [h,w] specular mask without what no layer explains yet
  std::vector<float> damping_;   // [diffuse surfels]
  std::vector<uint32_t> order_;  // photos of one epoch, in turn
  uint64_t order_epoch_ = ~uint64_t(0);
};

}  // namespace vitrine
