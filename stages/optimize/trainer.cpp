#include "stages/optimize/trainer.h"

#include <algorithm>

#include "core/foundation/base/log.h"
#include "core/foundation/base/rng.h"
#include "core/render/model/thick_glass.h"
#include "core/scene/surfels/activation.h"
#include "stages/optimize/outputs.h"
#include "stages/optimize/plane_inpainting.h"

namespace vitrine {

namespace {

constexpr double kInSolid = 0.1;  // largest initial opacity of surfels inside solid glass that were trained with straight rays
constexpr double kMediumFrom = 0.15;  // of the run: before, gaps between surfels would show the medium
constexpr double kMediumRate = 2e-3;  // largest step of the logarithm of a coefficient
// Poses move while the picture is coarse at first and has its full size later, until the last part of the run sharpens the scene.
// The way that a pose can go is independent of the number of steps and photos.
constexpr double kPosesFrom = 0.3, kPosesUntil = 0.8;
constexpr double kPoseReach = 7.5e-3;  // sum of the largest rates of a photo's visits: radians, scene radii
constexpr double kLeastPoseRate = 1e-4, kMostPoseRate = 1e-3, kPoseDecay = 0.1;
constexpr double kNoise = 0.2;       // random walk of nearly transparent surfels, relative to Kheradmand et al. 2024
constexpr double kNoiseScale = 5e5;  // strength of the noise per unit of the position rate in that paper

ImageOptions options_at(const PhaseClock& clock, const OptimizeConfig& c, int sh_degree) {
  return clock.image_options(c.shading, c.backend, sh_degree);
}

SplatScene first_scene(const TrainerSetup& setup, SplatLayer initial) {
  SplatScene scene{.diffuse = std::move(initial)};
  for (LayerKind kind : {LayerKind::Reflection, LayerKind::Transmittance})
    if (setup.layers.has(kind)) scene.layer(kind) = SplatLayer(kind, setup.config.phases.of(kind).sh_degree, 0);
  return scene;
}

bool poses_move(const TrainerSetup& setup, double fraction) {
  return setup.poses && fraction >= kPosesFrom && fraction < kPosesUntil;
}

PoseRates pose_rates_at(const TrainerSetup& setup, double fraction) {
  if (!poses_move(setup, fraction)) return {};
  const double visits = (kPosesUntil - kPosesFrom) * setup.config.iterations / double(setup.capture.train.size());
  const double rate = std::clamp(kPoseReach / visits, kLeastPoseRate, kMostPoseRate) *
                      std::pow(kPoseDecay, (fraction - kPosesFrom) / (kPosesUntil - kPosesFrom));
  return {.turn = rate, .shift = rate * kSceneRadius};
}

}  // namespace

Trainer::Trainer(const TrainerSetup& setup, SplatLayer initial, std::vector<ScenePlane> planes, double background)
    : Training({.capture = setup.capture,
                .targets = setup.targets,
                .losses = setup.config.loss,
                .steps = static_cast<uint64_t>(setup.config.iterations),
                .seed = static_cast<uint64_t>(setup.config.seed),
                .remedy = "lower the rates (--set optimize.rate_factor=0.1) or change the seed"},
               options_at({setup.config.phases, setup.layers, 0}, setup.config, setup.config.sh_degree),
               first_scene(setup, std::move(initial))),
      setup_(setup),
      densify_behind_glass_(setup.config.densify),
      planes_(std::move(planes)),
      background_(background),
      sheets_(trains_sheets(setup.config, setup.shapes) && setup.layers.transmittance),
      initial_surfels_(surfels(LayerKind::Diffuse)) {
  // Never relocate transmittance surfels for low weight: held-out views may see them.
  densify_behind_glass_.idle_weight = 0;
  if (setup_.medium) medium_.emplace(setup_.medium->kind, setup_.medium->coefficients);
}

// Reserves surfels for visual hulls until their phases begin.
size_t Trainer::diffuse_cap() const {
  const size_t all = cap(LayerKind::Diffuse);
  size_t room = 0;
  for (LayerKind kind : {LayerKind::Reflection, LayerKind::Transmittance})
    if (setup_.layers.has(kind) && !begun(kind) && !(sheets_ && kind == LayerKind::Transmittance))
      room += std::min(static_cast<size_t>(config().phases.most_hull_points(kind)), all / 10);
  return all - room;
}

size_t Trainer::cap(const TrainerSetup& setup, LayerKind kind) {
  const auto part = [&](LayerKind k) {
    if (!setup.layers.has(k) || (k == LayerKind::Transmittance && trains_sheets(setup.config, setup.shapes))) return size_t{0};
    return static_cast<size_t>(setup.config.phases.of(k).share * double(setup.config.max_gaussians));
  };
  if (kind != LayerKind::Diffuse) return part(kind);
  return static_cast<size_t>(setup.config.max_gaussians) - part(LayerKind::Reflection) - part(LayerKind::Transmittance);
}

StepPlan Trainer::plan() {
  begin_phases();
  fill_unseen();
  if (fraction() >= config().phases.joint.from) judge_layers();
  const OptimizeConfig& c = config();
  const PhaseClock clock = this->clock();
  StepPlan plan{.fraction = fraction(),
                .level = fraction() < c.resolution.quarter_until ? 2u
                         : fraction() < c.resolution.half_until  ? 1u
                                                                 : 0u,
                .image = image_options(),
                .rarest = float(c.rates.rarest),
                .withheld = judged_ ? std::span<const uint8_t>() : setup_.judges,
                // Inpainted surfels are not trained: their edges, which photos see, would drift into the gaps.
                .untrained = unseen_surfels_,
                .shapes = fraction() >= c.phases.reflection.surface_from ? &shapes_ : nullptr,
                .shape_rates = clock.shape_rates(),
                .medium = medium_ && fraction() >= kMediumFrom ? &*medium_ : nullptr,
                .medium_rate = kMediumRate * (fraction() < c.phases.joint.from ? 1 : c.phases.joint.rate_factor),
                // Masked glass sends rays only if the transmittance layer exists. Thin glass of known shape always sends rays.
                .glass_sends_rays = begun(LayerKind::Transmittance) && !sheets_,
                .known_mirrors = known_gloss_.empty() ? nullptr : &known_gloss_,
                .mirror_factor = static_cast<float>(c.phases.reflection.known_factor)};
  plan.pose_rates = pose_rates_at(setup_, fraction());
  for (LayerKind kind : kAllLayers) plan.rates[static_cast<size_t>(kind)] = clock.rates(kind, c.rates, kSceneRadius);
  if (setup_.layers.reflection && !begun(LayerKind::Reflection))
    plan.specular_weight = static_cast<float>(c.phases.diffuse.specular_weight);
  if (begun(LayerKind::Transmittance)) {
    plan.glass_factor = static_cast<float>(c.phases.transmittance.glass_factor);
    plan.one_glass = c.phases.transmittance.one_glass;
  }
  return plan;
}

void Trainer::end_step() {
  if (poses_move(setup_, fraction()) && step_index() % setup_.capture.train.size() == 0) poses_.hold_mean(setup_.capture.train);
  const DensifyConfig& d = config().densify;
  if (d.strategy == DensifyStrategy::None) return;
  const double f = fraction();
  const PhaseClock clock = this->clock();
  for (LayerKind kind : kAllLayers) {
    const bool first = kind == LayerKind::Diffuse;
    const double from = first ? d.from : config().phases.of(kind).from + d.from;
    const double until = first ? d.until : config().phases.of(kind).densify_until;
    if (!begun(kind) || f < from || f > until) continue;
    const auto seed = static_cast<uint64_t>(config().seed);
    const float rate = clock.rates(kind, config().rates, kSceneRadius)[static_cast<size_t>(Attribute::Mean)];
    const size_t gone = kind == LayerKind::Transmittance ? from_behind_glass_ : 0;
    const DensifyRhythm rhythm = densify_rhythm(d, setup_.capture.train.size(), (until - from) * config().iterations);
    move(kind, kind == LayerKind::Transmittance ? densify_behind_glass_ : d,
         {.moment = {.seed = first ? seed : mix64(seed, static_cast<uint64_t>(kind)),
                     .step = step_index(),
                     .cap = first ? diffuse_cap() : cap(kind) - gone,
                     .times = rhythm.times,
                     .scene_radius = kSceneRadius},
          .now = step_index() % rhythm.interval == 0 && pictures(kind) >= rhythm.pictures,
          .noise = static_cast<float>(kNoise * kNoiseScale * rate)});
  }
}

LayerInitDesc Trainer::init_desc() const {
  return {.config = config(),
          .capture = setup_.capture,
          .targets = setup_.targets,
          .shapes = setup_.shapes,
          .glass = setup_.glass,
          .sh_degree = sh_degree()};
}

void Trainer::begin_sheets() {
  ShapeSet sheets = known_sheets(init_desc(), scene_to_change());
  log_info("step {}: {} sheets and blocks of glass begin", step_index(), sheets.entries.size());
  shapes_.add(std::move(sheets));
  bend_in_solids();
  doubt_content_of_solids();
}

void Trainer::bend_in_solids() { solids_ = shapes_.set() ? solid_glass(*shapes_.set()) : nullptr; }

// Straight rays paint a picture of the refracted room into solid glass, which refracted rays meet as fog in front of the room.
// Lowers the opacity of surfels inside the glass; an object cast into the glass grows again.
void Trainer::doubt_content_of_solids() {
  if (!solids_) return;
  const float doubted = raw_value(row(Attribute::Opacity).activation, float(kInSolid));
  SplatLayer& diffuse = scene_to_change().diffuse;
  for (size_t i = 0; i < diffuse.size(); ++i) {
    const float* m = diffuse.at(Attribute::Mean, i);
    float& opacity = *diffuse.at(Attribute::Opacity, i);
    if (opacity > doubted && solids_->contains({m[0], m[1], m[2]})) opacity = doubted;
  }
}

// Adds the withheld specular pixels of the validation photos to training for the rest of the run.
void Trainer::judge_layers() {
  if (judged_ || !has_opaque_twin()) return;
  for (LayerKind kind : kAllLayers)
    if (setup_.layers.has(kind) && !begun(kind)) return;  // the shapes of the layer are not known yet
  judged_ = 1;
  ImageOptions options = image_options();
  options.surface.ray_budget = 0;
  options.opaque.layered = 1;
  if (options.shape.set) shapes_.set_layered(layered_shares(scene(), options, setup_.capture, setup_.targets, setup_.judges));
}

void Trainer::finish() {
  judge_layers();
  if (!sheets_ || !begun(LayerKind::Transmittance) || glass_surfels_ > 0) return;
  const HullCounts counts = begin_transmittance(init_desc(), SIZE_MAX, SIZE_MAX, scene_to_change());
  glass_surfels_ = counts.hull;
  log_info("{} surfels carry the glass; {} that are seen through it alone are the transmittance layer", counts.hull,
           counts.moved);
}

// Each layer starts from the current state of the diffuse layer.
void Trainer::begin_phases() {
  const PhaseClock clock = this->clock();
  const LayerInitDesc desc = init_desc();
  bool changed = false;
  for (LayerKind kind : {LayerKind::Reflection, LayerKind::Transmittance}) {
    if (begun(kind) || !clock.begun(kind)) continue;
    begun_[static_cast<size_t>(kind)] = 1;
    if (sheets_ && kind == LayerKind::Transmittance) {
      begin_sheets();
      continue;
    }
    changed = true;
    const auto begin = kind == LayerKind::Reflection ? begin_reflection : begin_transmittance;
    const HullCounts counts = begin(desc, cap(kind), diffuse_cap(), scene_to_change());
    log_info("step {}: the {} layer begins with {} surfels; {} were put on the hull of its masks, {} moved from there",
             step_index(), name(kind), surfels(kind), counts.hull, counts.moved);
    if (kind == LayerKind::Reflection && !counts.known_points.empty())
      known_gloss_ = KnownSurface(counts.known_points, counts.known_reach);
    ShapeSet known = counts.shapes;
    if (!config().shading.shapes) known = known.glass();
    if (!config().shading.panes) known = known.no_glass();
    shapes_.add(std::move(known));
    training(kind).restart(scene().layer(kind));
  }
  if (changed) training(LayerKind::Diffuse).restart(scene().diffuse);  // the surfels changed: reset the optimiser state
}

// Runs when densification has ended: relocation would remove surfels that no photo needs, or move them to other layers.
void Trainer::fill_unseen() {
  if (!config().fill_unseen || setup_.object_alone || filled_ || fraction() < config().densify.until) return;
  for (LayerKind kind : kAllLayers)
    if (setup_.layers.has(kind) && !begun(kind)) return;
  filled_ = 1;
  const bool thin_glass = config().shading.glass == Glass::Thin && setup_.layers.transmittance;
  if (thin_glass && !sheets_) fill_beside_glass();
  const SplatLayer unseen =
      inpainted_planes(thin_glass ? seen_through_glass(scene()) : scene().diffuse, setup_.capture, planes_, background_,
                       size_t(kMostUnseen * double(config().max_gaussians)), medium_ ? &medium_->coefficients() : nullptr);
  SplatLayer& diffuse = scene_to_change().diffuse;
  diffuse = joined(diffuse, unseen);
  unseen_surfels_ = unseen.size();
  training(LayerKind::Diffuse).grow(surfels(LayerKind::Diffuse));
  log_info("step {}: {} surfels close gaps of the surroundings that no photo shows; their colours are guessed", step_index(),
           unseen_surfels_);
}

void Trainer::fill_beside_glass() {
  const size_t before = surfels(LayerKind::Transmittance);
  const std::vector<uint32_t> stay = bring_out_from_behind_glass(setup_.capture, planes_, scene_to_change());
  from_behind_glass_ = before - stay.size();
  if (from_behind_glass_ == 0) return;
  training(LayerKind::Transmittance).keep_only(stay);
  training(LayerKind::Diffuse).grow(surfels(LayerKind::Diffuse));
  log_info("step {}: {} surfels of walls that photos show through glass alone close gaps next to the glass", step_index(),
           from_behind_glass_);
}

ImageOptions Trainer::image_options() const {
  ImageOptions options = options_at(clock(), config(), sh_degree());
  options.diffuse.near_z = setup_.capture.near_z;
  options.shape.set = shapes_.set();
  options.transmission.thick = solids_;
  if (medium_) options.medium = medium_->coefficients();
  if (judged_) options.opaque.layered = kLayeredElsewhere;
  if (filled_) options.panes.mirrored = surfels(LayerKind::Diffuse) - unseen_surfels_ - glass_surfels_;
  return options;
}

void Trainer::picture(uint32_t photo, bool layers, Frame& frame) const {
  ImageOptions options = image_options();
  options.surface.ray_budget = 0;
  options.composite.layer_images = layers;
  frame.differentiable = false;
  model_.forward(scene(), poses_.view(photo), options, frame);
}

void Trainer::transfer(Archive& archive) {
  Training::transfer(archive);
  archive.value(initial_surfels_);
  archive.value(begun_);
  archive.array(planes_);
  archive.value(background_);
  known_gloss_.transfer(archive);
  archive.value(filled_);
  archive.value(judged_);
  shapes_.transfer(archive);
  if (medium_) medium_->transfer(archive);
  if (setup_.poses) poses_.transfer(archive);
  bend_in_solids();
  archive.value(unseen_surfels_);
  archive.value(from_behind_glass_);
}

}  // namespace vitrine
