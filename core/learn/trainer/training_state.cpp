#include "core/learn/trainer/training_state.h"

#include <cmath>
#include <utility>

#include "core/render/raster/device.h"

namespace vitrine {

namespace {

// Constant when the program starts, as in device.cpp.
constinit StepPassMaker provided = nullptr;

}  // namespace

StepPassMaker provide_step_device(StepPassMaker maker) { return std::exchange(provided, maker); }

TrainingState::TrainingState(SplatScene start) : scene_(std::move(start)) {
  for (LayerKind kind : kAllLayers) layers_.emplace_back(scene_.layer(kind));
}

const SplatScene& TrainingState::scene() const {
  bring_back();
  return scene_;
}

SplatScene& TrainingState::scene_to_change() {
  bring_back();
  newest_ = Newest::Host;
  return scene_;
}

LayerTraining& TrainingState::layer_to_change(LayerKind kind) {
  bring_back();
  newest_ = Newest::Host;
  return layers_[static_cast<size_t>(kind)];
}

size_t TrainingState::surfels(LayerKind kind) const {
  return kind == LayerKind::Diffuse && on_device() ? device_->surfels() : scene_.layer(kind).size();
}

void TrainingState::transfer(Archive& archive) {
  bring_back();
  if (archive.reads()) newest_ = Newest::Host;
  for (LayerKind kind : kAllLayers) {
    SplatLayer& layer = scene_.layer(kind);
    LayerTraining& training = layers_[static_cast<size_t>(kind)];
    archive.layer(layer);
    training.transfer(archive);
    if (layer.kind() != kind || training.size() != layer.size()) archive.fail("its parts have different sizes");
  }
}

bool TrainingState::has_device() { return provided != nullptr && chosen_device() != nullptr; }

// Arrays of the diffuse layer on the host, for so many surfels.
blocks::StepState TrainingState::arrays(size_t surfels) const {
  const Adam::Moments adam = diffuse().adam().moments();
  SurfelAccumulator& sums = diffuse().accumulator();
  for (SplatLayer* layer : {&scene_.diffuse, &adam.m, &adam.v}) layer->resize(surfels);
  for (auto* values : {&sums.weight, &sums.error, &sums.screen_gradient, &sums.share}) values->resize(surfels);
  for (auto* values : {&adam.steps, &sums.seen}) values->resize(surfels);
  blocks::StepState state{.surfels = static_cast<uint32_t>(surfels),
                          .width = {},
                          .value = {},
                          .m = {},
                          .v = {},
                          .weight = sums.weight.data(),
                          .error = sums.error.data(),
                          .screen_gradient = sums.screen_gradient.data(),
                          .share = sums.share.data(),
                          .steps = adam.steps.data(),
                          .seen = sums.seen.data()};
  for (const AttributeRow& r : kAttributes) {
    const auto a = static_cast<size_t>(r.id);
    state.width[a] = static_cast<uint32_t>(scene_.diffuse.width(r.id));
    state.value[a] = scene_.diffuse.values(r.id).data();
    state.m[a] = adam.m.values(r.id).data();
    state.v[a] = adam.v.values(r.id).data();
  }
  return state;
}

void TrainingState::bring_back() const {
  if (newest_ != Newest::Device) return;
  with_device([&] { device_->get(arrays(device_->surfels())); });
  newest_ = Newest::Both;
}

void TrainingState::send() {
  if (newest_ == Newest::Host) {
    if (!device_) device_ = provided();
    device_->put(arrays(scene_.diffuse.size()));
  }
  newest_ = Newest::Device;
}

std::optional<blocks::StepReport> TrainingState::step(const blocks::StepDesc& desc, const blocks::StepPhoto& photo) {
  load_ = {surfels(LayerKind::Diffuse), desc.view.width, desc.view.height};
  return with_device([&] {
    send();
    ++diffuse().accumulator().pictures;
    return device_->step(desc, photo);
  });
}

std::optional<blocks::StepReport> TrainingState::report() {
  if (!device_) return std::nullopt;
  const auto report = with_device([&] { return device_->report(); });
  return report;
}

void TrainingState::move(const DensifyConfig& config, const LayerTraining::Move& move) {
  with_device([&] {
    send();
    if (move.now) {
      const blocks::StepPass::Moved done =
          device_->relocate(move.moment.seed, move.moment.step, config.idle_weight, std::pow(config.growth, move.moment.times),
                            static_cast<uint32_t>(move.moment.cap));
      diffuse().counts().relocated += done.relocated;
      diffuse().counts().added += done.added;
      diffuse().accumulator().pictures = 0;
    }
    if (move.noise > 0) device_->walk(move.noise, move.moment.seed, move.moment.step);
  });
}

}  // namespace vitrine
