// Fine-tuning of all layers at the final rates of optimize, with averaging of the scenes of its second part (Polyak and Juditsky
// 1992). Steps use one photo each, so the last step favours its photo; the mean over some epochs removes that bias. No surfel is
// added, moved or removed.
#pragma once

#include "core/learn/optim/rates.h"
#include "core/render/picture/trained_scene.h"
#include "core/learn/trainer/training.h"

namespace vitrine {

struct FineTuneConfig {
  int iterations = 600;
  int ray_budget = 0;
  int checkpoint_every = 100;
  // Not options; tests set them.
  bool unchanged = false;      // run even if neither removal of surfels nor refracted rays improved the glass
  double rate_factor = 0.2;    // relative to the rates at the end of training
  double glass_factor = 0.05;  // factor on the rates of geometry and opacity of transparent surfels
  RatesConfig rates;
  LossSet loss;
};
void describe(Describer& d, FineTuneConfig& c);

// Displacement of the glass surfels (tau above 1/2) in scene units. The mesh corresponds to their positions before it.
struct GlassMotion {
  double median = 0, p95 = 0;
};
GlassMotion glass_motion(const SplatLayer& before, const SplatLayer& after);

class FineTune : public Training {
 public:
  // All must outlive it; training uses the photos of `capture`.
  FineTune(const FineTuneConfig& config, const Capture& capture, const Targets& targets, const TrainedScene& start);

  // The mean scene so far; the current scene before averaging starts.
  const SplatScene& mean() const { return averaged_ > 0 ? mean_ : scene(); }

 private:
  StepPlan plan() override { return plan_; }
  void end_step() override;  // adds the scene to the mean
  void transfer(Archive& archive) override;

  StepPlan plan_;         // for all steps
  double average_after_;  // steps
  SplatScene mean_;
  uint64_t averaged_ = 0;  // number of scenes in the mean
};

}  // namespace vitrine
