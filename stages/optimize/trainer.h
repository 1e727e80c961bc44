// Training loop of the optimize stage: phases in which the layers begin, and growth of each layer (loop: core/learn/trainer).
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "core/observe/stereo/scene_planes.h"
#include "core/learn/trainer/medium_training.h"
#include "core/learn/trainer/training.h"
#include "stages/optimize/layer_init.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// Medium in front of the cameras at the start of training.
struct MediumStart {
  MediumKind kind;
  MediumCoefficients<double> coefficients;
};

// Inputs of a run; everything must outlive the trainer.
struct TrainerSetup {
  const OptimizeConfig& config;
  const Capture& capture;
  const Targets& targets;
  const ShapeSet& shapes;  // rendered by the image formation (ObjectSet::drawn_shapes)
  const ShapeSet& glass;   // shapes of all glass, including visual hulls
  LayerChoice layers;
  bool object_alone = false;             // (surroundings.h)
  std::span<const uint8_t> judges = {};  // [photo] validation photos of a scene with an opaque twin (outputs.h)
  std::optional<MediumStart> medium = {};
  bool poses = false;  // corrects the poses of the photos; one opaque layer
};

class Trainer : public Training {
 public:
  // `planes`, `background`: the large planes of the scene and the distance of its sky, for inpainting (plane_inpainting.h).
  Trainer(const TrainerSetup& setup, SplatLayer initial, std::vector<ScenePlane> planes, double background = 0);

  const LayerChoice& layers() const { return setup_.layers; }
  bool corrects_poses() const { return setup_.poses; }
  size_t from_behind_glass() const { return from_behind_glass_; }  // surfels moved to the diffuse layer (plane_inpainting.h)
  size_t unseen_surfels() const { return unseen_surfels_; }        // inpainted (plane_inpainting.h), in addition to the cap
  size_t initial_surfels() const { return initial_surfels_; }      // at the start of training
  static size_t cap(const TrainerSetup& setup, LayerKind kind);    // largest number of surfels of the layer
  size_t cap(LayerKind kind) const { return cap(setup_, kind); }

  void set_opaque_twin(SplatLayer twin) { scene_to_change().opaque = std::move(twin); }  // twin of the layers, before their first step
  // Renders one photo's view at full size with all rays (frame.srgb is the photo), and blends it with the opaque twin once the
  // layer shares are known; `layers`: also renders each layer separately.
  void picture(uint32_t photo, bool layers, Frame& frame) const;

  // Image options at this moment.
  ImageOptions image_options() const;

  // After the last step: determines the layer shares if that is still open. Glass trained without surfels gets the surfels that
  // other stages read, and content seen only through it becomes the transmittance layer. Pictures do not change.
  void finish();

 private:
  StepPlan plan() override;
  void end_step() override;  // relocates and adds surfels
  void transfer(Archive& archive) override;

  const OptimizeConfig& config() const { return setup_.config; }
  PhaseClock clock() const { return {config().phases, setup_.layers, fraction()}; }
  bool begun(LayerKind kind) const { return begun_[static_cast<size_t>(kind)] != 0; }
  int sh_degree() const { return fraction() < config().sh_from ? 0 : config().sh_degree; }
  size_t diffuse_cap() const;
  LayerInitDesc init_desc() const;
  void begin_phases();
  void begin_sheets();
  void bend_in_solids();
  void doubt_content_of_solids();
  void judge_layers();
  void fill_unseen();
  void fill_beside_glass();

  TrainerSetup setup_;
  DensifyConfig densify_behind_glass_;
  std::array<uint8_t, 3> begun_{1, 0, 0};  // [layer kind]
  std::vector<ScenePlane> planes_;
  double background_;
  std::shared_ptr<const ThickGlass> solids_;  // from shapes_, which do not move
  ShapeTraining shapes_;                      // mirrors and thin glass
  std::optional<MediumTraining> medium_;
  KnownSurface known_gloss_;                  // of mirrors
  uint8_t filled_ = 0;                        // unobserved regions are inpainted
  uint8_t judged_ = 0;                        // layer shares against the opaque twin are known
  bool sheets_;                               // thin glass is rendered from its shapes
  size_t glass_surfels_ = 0;                  // number of glass surfels after finish(): the last ones of the diffuse layer
  uint64_t initial_surfels_ = 0, unseen_surfels_ = 0, from_behind_glass_ = 0;
};

}  // namespace vitrine
