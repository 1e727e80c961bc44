#include "core/foundation/artifact/stage_cost.h"

#include <algorithm>
#include <cstdlib>

#include "core/foundation/artifact/stage_report.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"

namespace vitrine {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CaptureSize, photos, photographed_mpx, aspect, longest_px, texture, masks)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StageCost, cpu_s, parallel, memory_bytes, disk_bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CostTerms, capture, threads, options)

StageCost stage_cost(double cpu_s, double parallel, double memory_mib, double disk_mib) {
  constexpr double kMiB = 1024.0 * 1024.0;
  return {cpu_s, parallel, size_t(std::max(memory_mib, 0.0) * kMiB), size_t(std::max(disk_mib, 0.0) * kMiB)};
}

const std::string& CostTerms::text(const std::string& path) const {
  const auto found = options.find(path);
  if (found != options.end()) return found->second;
  throw Error(ErrorKind::Usage, fmt::format("--cost lacks the option '{}'", path),
              {.hint = "stages/README.md shows the form", .code = "USAGE"});
}

double CostTerms::number(const std::string& path) const { return std::strtod(text(path).c_str(), nullptr); }

bool CostTerms::is_given(const std::string& path) const { return !text(path).empty() && text(path) != "none"; }

double CostTerms::limited(const std::string& path, double below) const {
  const double own = number(path);
  return own <= 0 ? below : below <= 0 ? own : std::min(own, below);
}

double CostTerms::mpx(double max_side) const {
  const double side = max_side > 0 ? std::min(max_side, capture.longest_px) : capture.longest_px;
  return side * side * capture.aspect * 1e-6;
}

std::string to_json(const std::vector<CostTerms>& terms) { return nlohmann::json(terms).dump(); }
std::string to_json(const std::vector<StageCost>& costs) { return nlohmann::json(costs).dump(); }

std::vector<CostTerms> cost_terms_from_json(const std::string& text) {
  try {
    return nlohmann::json::parse(text).get<std::vector<CostTerms>>();
  } catch (const nlohmann::json::exception& e) {
    throw Error(ErrorKind::Usage, "--cost is no list of photos and options",
                {.why = e.what(), .hint = "stages/README.md shows the form", .code = "USAGE"});
  }
}

std::optional<std::vector<StageCost>> costs_from_json(const std::string& text) {
  try {
    return nlohmann::json::parse(text).get<std::vector<StageCost>>();
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

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
