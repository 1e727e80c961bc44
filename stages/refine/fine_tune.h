// A short training of all layers at the rates that optimize ended with, and the mean of the scenes that its second part went
// through. Photos are looked at one by one, so that the last step has made its photo a little better than the others; the mean
// over some epochs (Polyak and Juditsky 1992) takes that out. No surfel is added, moved or dropped.
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
  bool unchanged = false;      // also where neither removal of surfels nor bent rays improved the glass
  double rate_factor = 0.2;    // on the rates at the end of a training
  double glass_factor = 0.05;  // on the rates of geometry and opacity where surfels are transparent
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

class FineTune : public Training {
 public:
  // All must outlive it; the capture's training photos are looked at.
  FineTune(const FineTuneConfig& config, const Capture& capture, const Targets& targets, const TrainedScene& start);

  // The mean scene so far; as it is, until there is one.
  const SplatScene& mean() const { return averaged_ > 0 ? mean_ : scene_; }

 private:
  StepPlan plan() override { return plan_; }
  void end_step() override;  // the scene counts in the mean
  void transfer(Archive& archive) override;

  StepPlan plan_;         // of all steps
  double average_after_;  // steps
  SplatScene mean_;
  uint64_t averaged_ = 0;  // scenes in the mean
};

}  // namespace vitrine
