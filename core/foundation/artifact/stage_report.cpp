#include "core/foundation/artifact/stage_report.h"

#include "core/foundation/base/json.h"

namespace vitrine {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(ReportFigure, group, id, label, unit, decimals, good, fair, means, weak, value,
                                                fold, where, minus, over, samples, counted, fewest, shown_without, note)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(ReportFact, group, text, once, each)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(StageReport, file, figures, facts)

std::string stage_report_text(const StageReport& report) { return nlohmann::json(report).dump(); }

StageReport parse_stage_report(const std::string& text) {
  try {
    return nlohmann::json::parse(text).get<StageReport>();
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

}  // namespace vitrine
