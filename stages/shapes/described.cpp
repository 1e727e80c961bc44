// Cost estimate and report figures of the shapes stage.
#include "stages/shapes/shapes.h"
#include "stages/training_cost.h"

namespace vitrine {

StageCost shapes_cost(const CostTerms& t) {
  const double masks = t.photos() * t.mpx(t.limited("shapes.max_side", ingested_side(t)));
  const double reading = 0.08 * ingested_mpx(t);  // photos, for coats
  return stage_cost(0.05 * t.photos() + 1.5 * masks + reading, 0.8, 80 + 16 * masks, 5);
}

StageReport shapes_report() {
  StageReport report{.file = "shapes/shapes.json"};
  report.figures = {ReportFigure{"Geometry", "shapes_inside_masks", "Known shapes inside the masks", "%", 0, 0.9, 0.75,
                                 "Share of the pixels that show a box or a surface of revolution and that the masks mark.",
                                 "A shape is off its object: correct shapes.json, or mark the object in more photos.",
                                 "shapes.*.inside_masks"}
                        .folded("mean")};
  return report;
}

}  // namespace vitrine
