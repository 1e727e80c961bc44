// Cost estimate and report figures of the refine stage.
#include "stages/refine/refine.h"
#include "stages/training_cost.h"

namespace vitrine {

// Glass alone gives it anything to do; what masks hold, and whether there will be anything to train on, is not known before: at
// most so much.
StageCost refine_cost(const CostTerms& t) {
  if (!t.capture.masks) return stage_cost(0.1, 0.5, 90, 0.1);
  const double steps = t.number("refine.fine_tune.iterations");
  return stage_cost(0.6 * t.photos() + steps * training_step_s(t, 1, "refine.fine_tune.ray_budget"), 0.92,
                    1.05 * training_memory_mib(t), trained_surfels_disk_mib(t));
}

StageReport refine_report() {
  StageReport report{.file = "refine/report.json"};
  report.facts = {
      {.group = "Light and materials",
       .text = "the glass looks {verdict=thin,thick} (straight rays show what is behind it at "
               "{psnr.straight,psnr.straight_without_layer:1} dB, refracted ones at {psnr.bent,psnr.bent_without_layer:1} dB)",
       .each = "glass.regions"}};
  return report;
}

}  // namespace vitrine
