// Cost estimate and report figures of the decompose stage.
#include "stages/decompose/decompose.h"

namespace vitrine {

StageCost decompose_cost(const CostTerms& t) { return stage_cost(14 + 0.2 * t.photos(), 0.77, 350 + 4 * t.photos(), 6); }

StageReport decompose_report() {
  StageReport report{.file = "decompose/report.json"};
  report.figures = {
      {"Light and materials", "baked", "Light that stays baked in", "log", 2, 0.3, 0.6,
       "Photo against albedo times light, rms of the logarithm: what a new light will not move. Gloss and glass above all.",
       "Highlights and what glass shows keep the light of the photos under a new one.", "baked_log_rms"},
      ReportFigure{"Light and materials", "misfit", "Light and albedo against the colours", "log", 2, 0.3, 0.6,
                   "What albedo times light leaves unexplained on the surface, rms of the logarithm.",
                   "Shadows or colours of the light may have ended in the albedo.", "misfit_log_rms.*"}
          .folded("last")};
  return report;
}

}  // namespace vitrine
