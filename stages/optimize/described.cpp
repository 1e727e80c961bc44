// Cost estimate and report figures of the optimize stage.
#include "stages/optimize/optimize.h"
#include "stages/training_cost.h"

namespace vitrine {

StageCost optimize_cost(const CostTerms& t) {
  constexpr double kLayeredPart = 0.55;
  const double steps = t.number("optimize.iterations");
  const bool twin = t.capture.masks && t.text("optimize.opaque_twin") == "true" && t.text("optimize.layers") != "diffuse";
  const double step_s = training_step_s(t, kLayeredPart, "optimize.shading.ray_budget") + (twin ? opaque_step_s(t) : 0);
  return stage_cost(0.7 * t.photos() + steps * step_s, 0.92, training_memory_mib(t),
                    (twin ? 2 : 1) * trained_surfels_disk_mib(t));
}

StageReport optimize_report() {
  constexpr const char* kViews = "Pictures from new places";
  StageReport report{.file = "optimize/report.json"};
  report.facts = {{kViews, "{layers.*.surfels:n} surfels (by layer: {layers.*.surfels:parts})", "surfels"},
                  {kViews, "{surfels:n} surfels", "surfels"},
                  {kViews, "{iterations:n} training steps"}};
  return report;
}

}  // namespace vitrine
