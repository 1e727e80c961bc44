// Cost estimate and report figures of the objects stage.
#include "stages/objects/objects.h"
#include "stages/training_cost.h"

namespace vitrine {

StageCost objects_cost(const CostTerms& t) {
  const double masks = t.photos() * t.mpx(t.limited("objects.max_side", ingested_side(t)));
  const double reading = 0.08 * ingested_mpx(t);  // photos, for the coat test
  return stage_cost(0.05 * t.photos() + 1.5 * masks + reading, 0.8, 80 + 16 * masks, 5);
}

StageReport objects_report() {
  StageReport report{.file = "objects/objects.json"};
  report.figures = {ReportFigure{"Geometry", "objects_inside_masks", "Objects inside the masks", "%", 0, 0.9, 0.75,
                                 "Share of the pixels that show the shapes of objects and that the masks mark.",
                                 "A shape is off its object: correct objects.json, or mark the object in more photos.",
                                 "objects.*.evidence.inside_masks"}
                        .folded("mean")};
  return report;
}

}  // namespace vitrine
