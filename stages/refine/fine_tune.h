// A short training of all layers at the rates that optimize ended with, and the mean of the scenes that its second part went
// through. Photos are looked at one by one, so that the last step has made its photo a little better than the others; the mean
// over some epochs (Polyak and Juditsky 1992) takes that out. No surfel is added, moved or dropped.
#pragma once

#include "core/loss/loss_set.h"
#include "core/model/layered_model.h"
#include "core/optim/rates.h"
#include "core/picture/trained_scene.h"
#include "core/train/capture.h"
#include "core/train/layer_training.h"
#include "core/train/targets.h"

namespace vitrine {

struct FineTuneConfig {
  int iterations = 600;
  bool unchanged = false;
  double rate_factor = 0.2;
  double average_from = 0.25;
  double glass_factor = 0.05;
  double gate = 4;
  int ray_budget = 0;
  int seed = 1;
  int checkpoint_every = 100;
  RatesConfig rates;
  LossSet loss;
};
void describe(Describer& d, FineTuneConfig& c);

// How far the surfels of glass (tau above 1/2) have gone, scene units: half of them no further than the median, and so on. The
// mesh was made from where they were.
struct GlassMotion {
  double median = 0, p95 = 0;
};
GlassMotion glass_motion(const SplatLayer& before, const SplatLayer& after);

class FineTune {
 public:
  // All must outlive it; the capture's training photos are looked at.
  FineTune(const FineTuneConfig& config, const Capture& capture, const Targets& targets, const TrainedScene& start);

  void step();
  bool finished() const { return step_ >= static_cast<uint64_t>(config_.iterations); }
  uint64_t step_index() const { return step_; }
  // The mean scene so far; as it is, until there is one.
  const SplatScene& mean() const { return averaged_ > 0 ? mean_ : scene_; }

  void save(ArchiveWriter& out) const;
  void load(ArchiveReader& in);

 private:
  uint32_t photo_of_step() const;
  void update();
  void average();

  const FineTuneConfig& config_;
  const Capture& capture_;
  const Targets& targets_;
  LayeredModel model_;
  SplatScene scene_, grad_, mean_;
  std::vector<LayerTraining> training_;  // [layer kind]
  uint64_t step_ = 0, averaged_ = 0;     // averaged_: scenes in the mean
  Frame frame_;
  TargetImages images_;
  std::vector<float> target_, weight_, damping_;
};

}  // namespace vitrine
