// The training of the optimize stage: the loop of core/learn/trainer, the phases in which its layers begin, and the growth of each.
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "core/observe/stereo/scene_planes.h"
#include "core/learn/trainer/training.h"
#include "stages/optimize/layer_init.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// What a run is about; everything must outlive the trainer.
struct TrainerSetup {
  const OptimizeConfig& config;
  const Capture& capture;
  const Targets& targets;
  const ShapeSet& shapes;  // that the image formation draws (ObjectSet::drawn_shapes)
  const ShapeSet& glass;   // of all glass, visual hulls among them
  LayerChoice layers;
  bool object_alone = false;             // (surroundings.h)
  std::span<const uint8_t> judges = {};  // [photo] of a scene with an opaque twin (opaque_twin.h)
};

class Trainer : public Training {
 public:
  // `planes`, `background`: the large planes of the scene and the distance of its sky, where what no photo shows is guessed
  // (plane_inpainting.h).
  Trainer(const TrainerSetup& setup, SplatLayer initial, std::vector<ScenePlane> planes, double background = 0);

  const LayerChoice& layers() const { return setup_.layers; }
  size_t from_behind_glass() const { return from_behind_glass_; }  // surfels that went to the diffuse layer (plane_inpainting.h)
  size_t unseen_surfels() const { return unseen_surfels_; }        // for what no photo shows (plane_inpainting.h), beyond the cap
  size_t initial_surfels() const { return initial_surfels_; }      // that training started from
  static size_t cap(const TrainerSetup& setup, LayerKind kind);    // most surfels the layer may grow to
  size_t cap(LayerKind kind) const { return cap(setup_, kind); }

  void set_opaque_twin(SplatLayer twin) { scene_.opaque = std::move(twin); }  // of the layers, before their first step
  // Renders one photo's view at full size (frame.srgb is what the photo should show), with all rays, and blended with the opaque
  // twin once the layers are judged; `layers`: taken apart too.
  void picture(uint32_t photo, bool layers, Frame& frame) const;

  // Of the passes at this moment.
  ImageOptions image_options() const;

  // After the last step: the layers are judged, if they were not; glass that was trained without surfels gets those that other
  // stages and programs read, and what is seen through it alone becomes the transmittance layer. Pictures stay the same.
  void finish();

 private:
  StepPlan plan() override;
  void end_step() override;  // surfels move
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
  std::shared_ptr<const ThickGlass> solids_;  // of shapes_, which do not move
  ShapeTraining shapes_;                      // that mirror, and sheets of glass
  KnownSurface known_gloss_;                  // of what reflects
  uint8_t filled_ = 0;                        // what no photo shows
  uint8_t judged_ = 0;                        // the layers, against the opaque twin
  bool sheets_;                               // glass is drawn from its shapes
  size_t glass_surfels_ = 0;                  // that carry it, after finish(): the last ones of the diffuse layer
  uint64_t initial_surfels_ = 0, unseen_surfels_ = 0, from_behind_glass_ = 0;
};

}  // namespace vitrine
