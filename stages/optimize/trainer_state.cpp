// The state of a training run in a checkpoint: what load() reads back is all that the next step depends on.
#include "stages/optimize/trainer.h"

namespace vitrine {

void Trainer::save(ArchiveWriter& out) const {
  out.value(initial_surfels_);
  out.value(step_);
  out.value(bad_streak_);
  out.value(recent_loss_);
  out.value(epoch_);
  out.array(std::span<const EpochRecord>(epochs_));
  out.value(begun_);
  out.array(std::span<const ScenePlane>(planes_));
  out.value(background_);
  known_gloss_.save(out);
  out.value(filled_);
  shapes_.save(out);
  out.value(unseen_surfels_);
  out.value(from_behind_glass_);
  for (LayerKind kind : kAllLayers) {
    out.layer(scene_.layer(kind));
    training(kind).save(out);
  }
}

void Trainer::load(ArchiveReader& in) {
  in.value(initial_surfels_);
  in.value(step_);
  in.value(bad_streak_);
  in.value(recent_loss_);
  in.value(epoch_);
  in.array(epochs_);
  in.value(begun_);
  in.array(planes_);
  in.value(background_);
  known_gloss_.load(in);
  in.value(filled_);
  shapes_.load(in);
  in.value(unseen_surfels_);
  in.value(from_behind_glass_);
  bool fits = true;
  for (LayerKind kind : kAllLayers) {
    in.layer(scene_.layer(kind));
    training(kind).load(in);
    fits &= scene_.layer(kind).kind() == kind && training(kind).size() == scene_.layer(kind).size();
  }
  if (!fits || !in.at_end())
    throw Error(ErrorKind::Input, "a checkpoint is damaged",
                {.why = "its parts have different sizes", .hint = "the stage begins anew without it", .code = "BAD_CHECKPOINT"});
  grad_ = scene_.zeros_like();
}

}  // namespace vitrine
