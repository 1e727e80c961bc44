#include "pipeline/cost_model.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/median.h"

namespace vitrine {

void take_typical_size(std::vector<std::pair<double, double>> sides, CaptureSize& capture) {
  const auto [shorter, longer] = upper_median(std::move(sides));
  capture.longest_px = longer;
  capture.aspect = shorter / longer;
}

bool gives_masks(const Settings& settings) {
  const Option* masks = settings.options.table.find("input.masks");
  return masks != nullptr && !masks->text().empty() && masks->text() != "none";
}

CostTerms cost_terms(const Settings& settings, const CaptureSize& capture, int threads) {
  CostTerms terms{.capture = capture, .threads = std::max(threads, 1), .options = {}};
  for (const Option& o : settings.options.table.options) terms.options[o.path] = o.text();
  return terms;
}

CostAnswer stage_costs(const StageNode& stage, const std::vector<CostTerms>& terms) {
  if (!stage.has_cost) return {{}, "it declares no estimate"};
  if (terms.empty() || terms.front().capture.photos == 0) return {{}, "there is no photo"};
  const TemporaryFolder folder("vitrine-cost");
  const fs::path file = folder.path() / "terms.json";
  write_file(file, to_json(terms));
  std::string answer;
  ProcessResult ended;
  try {
    ended = run_process({.arguments = {stage.executable.string(), "--cost", file.string()},
                         .on_line = [&](std::string_view line) { answer = line; }});
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Dependency) throw;
    return {{}, "its program cannot be started"};
  }
  throw_if_interrupted();
  auto costs = ended.ok() ? costs_from_json(answer) : std::nullopt;
  if (!costs || costs->size() != terms.size()) return {{}, "its program does not answer --cost"};
  return {std::move(*costs), {}};
}

}  // namespace vitrine
