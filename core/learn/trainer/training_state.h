// State of a training: surfels, moments of Adam and statistics of all layers, on the host or, for steps of one opaque layer, in
// the memory of the chosen device (blocks/step_pass.h). The newer copy of the diffuse layer is moved when the other side needs it
// and not before; nobody can read the older one.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/learn/trainer/blocks/step_pass.h"
#include "core/learn/trainer/layer_training.h"
#include "core/render/raster/blocks/device_host.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

class TrainingState {
 public:
  explicit TrainingState(SplatScene start);

  // Of the host. Those that may change the state make the copy of the device the older one.
  const SplatScene& scene() const;
  SplatScene& scene_to_change();
  LayerTraining& layer_to_change(LayerKind kind);

  // Known without a copy.
  size_t surfels(LayerKind kind) const;
  size_t opaque_twin_surfels() const { return scene_.opaque.size(); }
  bool knows_objects() const { return !scene_.diffuse.object_ids().empty(); }
  int sh_degree() const { return scene_.diffuse.sh_degree(); }
  uint32_t pictures(LayerKind kind) const { return layer(kind).pictures(); }
  const TrainCounts& counts(LayerKind kind) const { return layer(kind).counts(); }

  // Of all layers. Throws Error{Input} if the data read is invalid.
  void transfer(Archive& archive);

  // Whether a device is chosen that makes training steps.
  static bool has_device();
  // The newer state of the diffuse layer is on the device.
  bool on_device() const { return newest_ == Newest::Device; }
  // As StepPass; the state is copied to the device before if it is not there. Errors: those of blocks::on_device().
  std::optional<blocks::StepReport> step(const blocks::StepDesc& desc, const blocks::StepPhoto& photo);
  std::optional<blocks::StepReport> report();
  void count_skipped(size_t gradients) { diffuse().counts().skipped_gradients += gradients; }
  // As LayerTraining::move() with `divide`.
  void move(const DensifyConfig& config, const LayerTraining::Move& move);

 private:
  enum class Newest { Host, Both, Device };
  const LayerTraining& layer(LayerKind kind) const { return layers_[static_cast<size_t>(kind)]; }
  LayerTraining& diffuse() const { return layers_[static_cast<size_t>(LayerKind::Diffuse)]; }
  void bring_back() const;
  void send();
  blocks::StepState arrays(size_t surfels) const;
  template <class Run>
  auto with_device(const Run& run) const {
    return blocks::on_device(load_, run);
  }

  // Of the diffuse layer only counts and pictures are right while the device has the newer state.
  mutable SplatScene scene_;
  mutable std::vector<LayerTraining> layers_;  // [layer kind]
  mutable Newest newest_ = Newest::Host;
  std::unique_ptr<blocks::StepPass> device_;
  blocks::DeviceLoad load_{};
};

}  // namespace vitrine
