// Cost estimate and report figures of the normals stage.
#include "stages/normals/normals.h"
#include "stages/training_cost.h"

namespace vitrine {

StageCost normals_cost(const CostTerms& t) {
  const double out = t.photos() * t.mpx(t.limited("normals.max_side", ingested_side(t)));
  const double stereo = t.photos() * t.mpx(t.limited("normals.geometric.max_side", ingested_side(t)));
  return stage_cost(0.6 * t.photos() + 22 * stereo, 0.95, 90 + 4 * out, 1.2 * out);
}

StageReport normals_report() {
  StageReport report{.file = "normals/report.json"};
  report.figures = {ReportFigure{"Geometry", "normals_known", "Surface known before training", "%", 0, 0.6, 0.3,
                                 "Share of the pixels with a normal from stereo, hulls, files or a network.",
                                 "Training begins with little knowledge of the surface: plain or shiny areas.", "photos.*.known"}
                        .folded("mean")
                        .noted("source: {source}")};
  return report;
}

}  // namespace vitrine
