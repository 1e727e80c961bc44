// Steps of a training that the kernels for a device know, and those steps as they take them.
#include <algorithm>

#include "core/learn/trainer/training.h"

namespace vitrine {

namespace {

// Losses of rays and of blended materials have value 0 in the picture of one opaque layer, which shows neither.
bool needs_layers(std::string_view loss) { return loss == "first_hit" || loss == "specular_mask" || loss == "transmission_mask"; }

bool one_opaque_layer(const StepPlan& plan, const TrainingState& state) {
  const ImageOptions& image = plan.image;
  return state.surfels(LayerKind::Diffuse) > 0 && state.surfels(LayerKind::Reflection) == 0 &&
         state.surfels(LayerKind::Transmittance) == 0 && state.opaque_twin_surfels() == 0 && !image.shape.set &&
         !image.transmission.thick && !image.medium && !image.diffuse.materials && image.diffuse.backend == Backend::Cpu;
}

}  // namespace

bool device_knows(const StepPlan& plan, const LossSet& losses, uint64_t step_index, const TrainingState& state) {
  if (!TrainingState::has_device() || !one_opaque_layer(plan, state) || state.knows_objects()) return false;
  if (plan.medium || plan.pose_rates.turn > 0 || plan.glass_factor || plan.known_mirrors || plan.one_glass) return false;
  return std::ranges::all_of(losses.terms(), [&](const LossTerm& term) {
    const std::string_view name = term.factory->name;
    return term.schedule.at(plan.fraction) == 0 || needs_layers(name) || blocks::block_loss(name) ||
           !term.loss->takes_part(step_index);
  });
}

blocks::StepDesc device_step(const StepPlan& plan, const LossSet& losses, const TrainingState& state, const View& view,
                             bool withheld) {
  RasterDesc raster;
  raster.intrinsics = view.intrinsics;
  raster.cam_from_world = view.cam_from_world;
  raster.sh_degree = plan.image.diffuse.sh_degree;
  raster.near_z = plan.image.diffuse.near_z;
  blocks::StepDesc step{};
  step.view = blocks::block_view(raster, state.sh_degree());
  for (size_t c = 0; c < 3; ++c) step.gain[c] = static_cast<float>(view.gain[c]);
  step.clipped = kClippedSrgb;
  step.specular_weight = plan.specular_weight;
  step.withheld = withheld;
  for (const LossTerm& term : losses.terms())
    if (const auto loss = blocks::block_loss(term.factory->name); loss && !needs_layers(term.factory->name))
      step.losses[*loss] = term.schedule.at(plan.fraction);
  std::ranges::copy(plan.rates[static_cast<size_t>(LayerKind::Diffuse)], step.rates);
  step.rarest = std::max(1.f, plan.rarest);
  step.trained = static_cast<uint32_t>(state.surfels(LayerKind::Diffuse) - plan.untrained);
  return step;
}

blocks::StepPhoto device_photo(uint32_t photo, size_t level, const PhotoLevel& picture, const TargetLevel& targets) {
  const auto data = [](const auto& values) { return values.empty() ? nullptr : values.data(); };
  const auto mask = [&](MaskClass m) { return data(targets.masks[static_cast<size_t>(m)]); };
  return {.photo = photo,
          .level = static_cast<uint32_t>(level),
          .pixels = static_cast<uint32_t>(picture.view.intrinsics.pixel_count()),
          .srgb = picture.srgb.data(),
          .specular = mask(MaskClass::Specular),
          .transparent = mask(MaskClass::Transparent),
          .object = mask(MaskClass::Object),
          .ignore = mask(MaskClass::Ignore),
          .coat = data(targets.coat),
          .normals = data(targets.normals),
          .confidence = data(targets.confidence)};
}

}  // namespace vitrine
