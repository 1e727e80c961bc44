#include "stages/optimize/training_part.h"

#include <algorithm>

#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/timer.h"
#include "stages/optimize/outputs.h"
#include "stages/optimize/surroundings.h"

namespace vitrine {

namespace {

constexpr double kFarFactor = 5;  // stereo searches up to this factor times the farthest sparse point; farther content may be sky

std::unique_ptr<Trainer> trainer_from_start(const TrainerSetup& setup, const DenseDepth& dense) {
  const Capture& capture = setup.capture;
  std::function<bool(const Vec3d&)> keep;
  if (setup.object_alone) keep = [&](const Vec3d& p) { return on_object(capture, setup.targets, p); };
  SplatLayer initial = initial_layer(setup.config, capture, dense, Trainer::cap(setup, LayerKind::Diffuse), keep,
                                     setup.medium ? &setup.medium->coefficients : nullptr);
  log_info("{} photos to train on, {} held out, {} surfels to start from, at most {}", capture.train.size(),
           capture.heldout.size(), initial.size(), setup.config.max_gaussians);
  return std::make_unique<Trainer>(setup, std::move(initial), dense.planes, dense.background);
}

void report_progress(const Trainer& trainer, const TrainingPart& part, int iterations, StageContext& context) {
  const double step = double(trainer.step_index()), surfels = double(surfel_count(trainer));
  context.progress({.fraction = part.from + part.share * step / iterations,
                    .text = fmt::format("{}step {}/{}  loss {:.4f}  {:.0f}k surfels", part.name, trainer.step_index(), iterations,
                                        trainer.recent_loss(), surfels / 1000),
                    .values = {{"step", step}, {"loss", trainer.recent_loss()}, {"surfels", surfels}}});
}

}  // namespace

void check_memory(const OptimizeConfig& config, const Capture& capture, const StageContext& context) {
  const size_t limit = context.max_memory_bytes();
  if (limit == 0) return;
  const size_t before =
      bytes_before_surfels(capture.view_set, config.max_side, context.optional_input("masks"), context.optional_input("normals"));
  if (affordable_surfels(config, before, limit) >= std::min(kFewestSurfels, static_cast<size_t>(config.max_gaussians))) return;
  throw Error(ErrorKind::Resource, "the photos do not fit into the memory limit",
              {.where = fmt::format("limit {} MiB", limit >> 20),
               .why = fmt::format("photos and pictures need {} MiB before the first surfel", before >> 20),
               .hint = fmt::format("raise --max-memory, --set optimize.max_side=640, or {}",
                                   config.blocks > 1 ? "more --blocks" : "--blocks 4"),
               .code = "OUT_OF_MEMORY"});
}

const DenseDepth& LazyDepth::get() {
  if (depth_) return *depth_;
  const Timer timer;
  depth_ = dense_depth(capture_, config_.initial.stereo_side, kFarFactor, uint64_t(config_.seed), known_);
  context_.timing("stereo_seconds", timer.seconds());
  log_info("dense stereo: {:.0f} % of the pixels of {} photos have a reliable depth, {:.1f} s", 100 * depth_->reliable_share(),
           capture_.train.size(), timer.seconds());
  return *depth_;
}
size_t surfel_count(const Trainer& trainer) {
  size_t count = 0;
  for (LayerKind kind : kAllLayers) count += trainer.surfels(kind);
  return count;
}

// Resumes from the checkpoint if it is valid.
std::unique_ptr<Trainer> started(const TrainerSetup& setup, const fs::path& checkpoint, LazyDepth& depth, StageContext& context) {
  auto trainer =
      std::make_unique<Trainer>(setup, SplatLayer(LayerKind::Diffuse, setup.config.sh_degree, 0), std::vector<ScenePlane>{});
  if (!trainer->resume(checkpoint, [&](const std::string& why) { context.warning("CHECKPOINT_IGNORED", why); }))
    trainer = trainer_from_start(setup, depth.get());
  return trainer;
}

void train(const OptimizeConfig& config, const Capture& capture, Trainer& trainer, const TrainingPart& part,
           StageContext& context) {
  const uint32_t shown = capture.heldout.empty() ? capture.train.front() : capture.heldout[capture.heldout.size() / 2];
  const uint64_t first_step = trainer.step_index();
  const Timer timer;
  trainer.run({.checkpoint = part.checkpoint,
               .checkpoint_every = config.checkpoint_every,
               .after_step =
                   [&] {
                     const auto period = static_cast<uint64_t>(config.preview_every);
                     if (!part.previews.empty() && (trainer.finished() || (period > 0 && trainer.step_index() % period == 0)))
                       write_preview(part.previews / fmt::format("step_{:06}.png", trainer.step_index()), trainer, capture,
                                     shown);
                     report_progress(trainer, part, config.iterations, context);
                   },
               .after_checkpoint = [&] { context.checkpoint(part.from + part.share * trainer.fraction()); }});
  if (!trainer.sound())
    throw Error(ErrorKind::Diverged, "training broke down: at its end the surfels are gone or no numbers",
                {.where = fmt::format("step {}", trainer.step_index()),
                 .hint = "lower the rates (--set optimize.rate_factor=0.1) or change the seed",
                 .code = "COLLAPSED"});
  if (!part.previews.empty() && trainer.step_index() > first_step)
    context.timing("seconds_per_step", timer.seconds() / double(trainer.step_index() - first_step));
}

}  // namespace vitrine
