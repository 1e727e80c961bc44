#include "pipeline/cost_model.h"

#include <algorithm>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/terminal.h"
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

std::optional<CaptureSize> ingested_capture(const fs::path& project, const Settings& settings) {
  const auto key = current_key(project, "ingest");
  if (!key) return std::nullopt;
  const fs::path file = store_of(project) / "ingest" / *key / "ingest/photos.json";
  std::error_code ec;
  if (!fs::exists(file, ec)) return std::nullopt;
  const auto list = nlohmann::json::parse(read_file(file), nullptr, false);
  if (!list.is_object() || !list.contains("photos")) return std::nullopt;
  CaptureSize c{.texture = kUsualTexture};
  std::vector<std::pair<double, double>> sides;  // shorter, longer
  for (const auto& photo : list["photos"]) {
    const double w = photo.value("original_width", 0.0), h = photo.value("original_height", 0.0);
    if (w < 1 || h < 1) continue;
    sides.push_back(std::minmax(w, h));
    c.photographed_mpx += w * h * 1e-6;
  }
  if (sides.empty()) return std::nullopt;
  c.photos = sides.size();
  take_typical_size(std::move(sides), c);
  c.masks = gives_masks(settings);
  return c;
}

Preflight preflight(const std::vector<const StageNode*>& stages, const Settings& settings, const CaptureSize& capture,
                    int threads, const Resources& there) {
  Preflight p;
  const CostTerms terms = cost_terms(settings, capture, threads);
  for (const StageNode* stage : stages) {
    const CostAnswer answer = stage_costs(*stage, {terms});
    if (answer.costs.empty()) {
      p.unknown.push_back(fmt::format("{} ({})", stage->name, answer.problem));
      continue;
    }
    const StageCost& cost = answer.costs.front();
    p.seconds += cost.seconds(threads);
    p.disk_bytes += cost.disk_bytes;
    if (cost.memory_bytes > p.memory_bytes) {
      p.memory_bytes = cost.memory_bytes;
      p.hungriest = stage->name;
    }
  }
  if (double(p.disk_bytes) > kUsualCostError * double(there.disk_bytes))
    throw Error(ErrorKind::Resource, "the disk is too small for the results",
                {.where = bytes_text(there.disk_bytes) + " are free",
                 .why = fmt::format("the stages to come write about {}", bytes_text(p.disk_bytes)),
                 .hint = "free some space, choose another disk with -o, or --no-preflight to begin all the same",
                 .code = "DISK_TOO_SMALL"});
  if (p.disk_bytes > there.disk_bytes)
    p.notes.push_back(fmt::format("note: the disk may be too small: about {} will be written, {} are free",
                                  bytes_text(p.disk_bytes), bytes_text(there.disk_bytes)));
  if (p.memory_bytes > there.memory_bytes)
    p.notes.push_back(
        there.memory_is_limit
            ? fmt::format("note: {} may need about {}, --max-memory allows {}: it takes less where it can, else it "
                          "stops with exit code 6 and names the option that helps",
                          p.hungriest, bytes_text(p.memory_bytes), bytes_text(there.memory_bytes))
            : fmt::format("note: {} may need about {} and {} are free: with --max-memory 80% it makes do, or stops in "
                          "order instead of being killed",
                          p.hungriest, bytes_text(p.memory_bytes), bytes_text(there.memory_bytes)));
  return p;
}

std::string preflight_line(const Preflight& p, const Resources& there) {
  const std::string unknown = fmt::format("{}", fmt::join(p.unknown, ", "));
  if (p.hungriest.empty()) return "to come: no stage has an estimate of its costs: " + unknown;
  return fmt::format("to come: about {}, {} of memory ({}), {} of disk ({} free){}", duration_text(p.seconds),
                     bytes_text(p.memory_bytes), p.hungriest, bytes_text(p.disk_bytes), bytes_text(there.disk_bytes),
                     unknown.empty() ? std::string() : "; without an estimate, and not in the sum: " + unknown);
}

}  // namespace vitrine
