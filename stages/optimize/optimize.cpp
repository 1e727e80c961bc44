#include "stages/optimize/optimize.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/timer.h"
#include "core/learn/trainer/capture.h"
#include "core/render/picture/part_labels.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/blocks.h"
#include "stages/optimize/initialise.h"
#include "stages/optimize/medium_fit.h"
#include "stages/optimize/outputs.h"
#include "stages/optimize/surroundings.h"
#include "stages/optimize/training_part.h"
#include "stages/optimize/transients.h"

namespace vitrine {

namespace {

constexpr double kScoutShare = 0.05, kTwinShare = 0.25;  // of the time

// Short training that finds transient content, which then does not take part in training. Needs enough photos to compare.
Transients ignored_transients(const TrainerSetup& whole, Targets& targets, LazyDepth& depth, StageContext& context) {
  OptimizeConfig config;
  configure_scout(whole.config, whole.capture, config);
  const TrainerSetup setup{
      .config = config, .capture = whole.capture, .targets = targets, .shapes = whole.shapes, .glass = whole.glass, .layers = {}};
  const TrainingPart part{"transient content, ", 0, kScoutShare, context.scratch() / "scout.bin"};
  const std::unique_ptr<Trainer> scout = started(setup, part.checkpoint, depth, context);
  train(config, whole.capture, *scout, part, context);
  Transients found = found_transients(*scout, whole.capture, targets);
  ignore_transients(found, targets, whole.capture);
  log_info(
      "transient content: {} of {} photos show some, {:.1f} % of their pixels are not trained on (--set "
      "optimize.transients=off)",
      found.photos, whole.capture.train.size(), 100 * found.share);
  return found;
}

bool finds_transients(const OptimizeConfig& config, const Targets& targets, const Surroundings& surroundings,
                      const Capture& capture) {
  return config.transients == WantedTransients::Auto && !targets.any(MaskClass::Ignore) &&
         surroundings.trained == Trained::Everything && capture.train.size() >= kFewestForTransients;
}

SplatLayer trained_twin(const TrainerSetup& layered, double from, LazyDepth& depth, StageContext& context) {
  const TrainerSetup setup{.config = layered.config,
                           .capture = layered.capture,
                           .targets = layered.targets,
                           .shapes = layered.shapes,
                           .glass = layered.glass,
                           .layers = {},
                           .object_alone = layered.object_alone,
                           .judges = layered.judges};
  const TrainingPart part{"opaque twin, ", from, kTwinShare, context.scratch() / "opaque_twin.bin"};
  const std::unique_ptr<Trainer> trainer = started(setup, part.checkpoint, depth, context);
  train(layered.config, layered.capture, *trainer, part, context);
  return trainer->scene().diffuse;
}

// Held-out photos follow the scene as those that train it do. Their views get the corrected poses.
void align_heldout(Trainer& trainer, Capture& capture) {
  for (const uint32_t photo : capture.heldout) {
    throw_if_interrupted();
    trainer.align(photo);
  }
  for (size_t photo = 0; photo < capture.photos.size(); ++photo)
    capture.view_set.views[photo].cam_from_world = trainer.poses().pose(photo);
  const PoseDistance moved = trainer.poses().moved(capture.train);
  log_info("poses: training photos turned by {:.3f} degrees, {:.3f} at most, and moved by {:.4f} scene units, {:.4f} at most",
           moved.turn_rad * 180 / std::numbers::pi, moved.largest_turn_rad * 180 / std::numbers::pi, moved.shift,
           moved.largest_shift);
}

void log(const Surroundings& surroundings) {
  constexpr const char* kOtherwise = " (--set optimize.surroundings=train)";
  if (surroundings.trained == Trained::ObjectAlone)
    log_info("the object is trained alone{}",
             surroundings.why.empty() ? "" : fmt::format(", its surroundings move: {}{}", surroundings.why, kOtherwise));
  else if (surroundings.trained == Trained::StillPart)
    log_info("a part of the surroundings moves against the object and weighs nothing: {}{}", surroundings.why, kOtherwise);
  else if (!surroundings.why.empty())
    log_info("{}", surroundings.why);
}

void log(const std::optional<ChosenMedium>& medium, WantedMedium wanted, StageContext& context) {
  if (!medium) return;
  if (!medium->start && wanted != WantedMedium::Auto)
    context.warning("NO_MEDIUM", medium->why);
  else
    log_info("{}", medium->why);
}

}  // namespace

void run_optimize(const OptimizeConfig& config, StageContext& context) {
  set_thread_limit(context.threads());
  if (config.blocks > 1) return train_in_blocks(config, context);
  Capture capture = load_capture(context.input("sfm"), config.max_side, config.holdout_every);
  const Passes passes = read_passes(context.input("sfm"));
  if (config.surroundings == WantedSurroundings::Train) keep_largest_pass(passes, capture);
  const LabelledObjects objects = LabelledObjects::trusted(context.optional_input("objects"));
  Targets targets = load_targets(capture, context.optional_input("masks"), objects, context.optional_input("normals"));
  const ShapeSet shapes = objects.objects().drawn_shapes();
  const ShapeSet glass = objects.objects().shapes.glass();
  for (const TargetProblem& problem : targets.warnings) context.warning(problem.code, problem.text);
  check_memory(config, capture, context);
  const LayerChoice layers = chosen_layers(config.layers, targets.any(MaskClass::Specular), targets.any(MaskClass::Transparent));
  if (config.layers == WantedLayers::Auto && !layers.any() && !read_objects(context.optional_input("objects")).empty())
    log_info("glass and mirrors are only guessed: one opaque layer (correct objects/objects.json and give it with --objects)");
  LazyDepth depth(config, capture, known_depth_of(capture, targets, context.optional_input("normals")), context);
  const Surroundings surroundings = surroundings_to_train(
      config.surroundings, passes, capture, [&]() -> const DenseDepth& { return depth.get(); }, targets);
  log(surroundings);
  const bool alone = surroundings.trained != Trained::Everything, still_part = surroundings.trained == Trained::StillPart;
  if (!alone) targets.forget(MaskClass::Object);  // the object loss would suppress everything outside the object
  if (capture.view_set.points.empty())
    context.warning("NO_SPARSE_POINTS", "no sparse point gives a depth: the first surfels lie at random distances");
  const std::optional<ChosenMedium> medium = chosen_medium(
      config.medium, capture, targets, [&]() -> const DenseDepth& { return depth.get(); }, uint64_t(config.seed));
  log(medium, config.medium, context);
  const bool has_twin = config.opaque_twin && layers.any() && !(medium && medium->start);
  const std::vector<uint8_t> judges = has_twin ? judging_photos(capture) : std::vector<uint8_t>();
  const TrainerSetup setup{.config = config,
                           .capture = capture,
                           .targets = targets,
                           .shapes = shapes,
                           .glass = glass,
                           .layers = layers,
                           .object_alone = alone,
                           .judges = judges,
                           .medium = medium ? medium->start : std::nullopt,
                           .poses = config.poses == WantedPoses::Auto && !layers.any()};
  if (config.poses == WantedPoses::Auto && layers.any())
    context.warning("POSES_GIVEN", "poses stay as given: they are corrected where one opaque layer is trained (optimize.layers)");
  const bool scouts = finds_transients(config, targets, surroundings, capture);
  if (scouts) {
    const Transients transients = ignored_transients(setup, targets, depth, context);
    context.metric("transient_photos", double(transients.photos));
    if (transients.photos > 0) write_transients(context.output() / "optimize/transients", transients, capture);
  }
  const double scouted = scouts ? kScoutShare : 0;
  SplatLayer opaque = has_twin ? trained_twin(setup, scouted, depth, context) : SplatLayer();
  const double before = scouted + (has_twin ? kTwinShare : 0);
  const fs::path previews = context.scratch() / "previews";
  const TrainingPart part{"", before, 1 - before, context.scratch() / "checkpoint.bin", previews};
  const std::unique_ptr<Trainer> trainer = started(setup, part.checkpoint, depth, context);
  trainer->set_opaque_twin(std::move(opaque));
  depth.forget();
  train(config, capture, *trainer, part, context);
  trainer->finish();
  if (setup.poses) {
    align_heldout(*trainer, capture);
    write_corrected_poses(context.output(), capture.view_set.views);
  }

  const std::vector<PhotoQuality> heldout = measure(*trainer, capture, targets);
  SplatScene scene = trainer->scene();
  std::vector<View> seen;
  for (const uint32_t photo : capture.train) seen.push_back(capture.view_set.views[photo]);
  const LabelledObjects known = LabelledObjects::known(context.optional_input("objects"));
  const std::vector<LabelledView> labelled = labelled_views(known, seen);
  assign_objects(known.objects(), labelled, capture.near_z, scene.diffuse, scene.transmittance);
  if (has_twin && !labelled.empty()) {
    std::vector<uint16_t> ids = labels_of_surfels(scene.opaque, capture.near_z, labelled).label;
    leave_out_thin_glass(known.objects(), ids);
    scene.opaque.set_object_ids(std::move(ids));
  }
  for (LayerKind kind : kAllLayers)
    if (layers.has(kind)) write_layer(context.output() / fmt::format("gaussians/{}.ply", name(kind)), scene.layer(kind));
  if (has_twin) write_layer(context.output() / "gaussians/opaque.ply", scene.opaque);
  write_image_options(context.output() / "optimize/model.json", trainer->image_options());
  write_views(context.output() / "optimize/views.json", config, capture, alone);
  if (still_part) write_trained_masks(context.output() / "optimize/trained", capture, targets);
  write_report(context.output() / "optimize/report.json", config, capture, *trainer, heldout);
  make_folders(previews);
  // Previews are linked from the scratch folder, which keeps those written before an interruption.
  for (const auto& file : fs::directory_iterator(previews))
    link_or_copy(file.path(), context.output() / "optimize/previews" / file.path().filename());

  const double surfels = double(surfel_count(*trainer));
  context.metric("surfels", surfels);
  context.metric("loss", trainer->epochs().empty() ? trainer->recent_loss() : trainer->epochs().back().loss);
  std::string text = fmt::format("{:.0f}k surfels", surfels / 1000);
  if (!heldout.empty()) {
    context.metric("heldout_psnr", mean_psnr(heldout));
    text += fmt::format(", held-out PSNR {:.2f} dB", mean_psnr(heldout));
  }
  context.summary(text);
}

}  // namespace vitrine
