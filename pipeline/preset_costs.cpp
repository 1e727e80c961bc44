#include "pipeline/cost_model.h"

#include <algorithm>

#include <fmt/format.h>

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::vector<PresetCost> preset_costs(const Graph& graph, const CostInputs& inputs, const CaptureSize& capture, int threads) {
  std::vector<PresetCost> costs;
  std::vector<CostTerms> terms;
  for (const std::string& name : preset_names()) {
    Settings settings(graph);
    settings.load({.flags = {{"preset", name, "--preset"},
                             {"input.photos", inputs.photos.string(), "PHOTOS"},
                             {"input.truth", inputs.truth, "the project"}}});
    terms.push_back(cost_terms(settings, capture, threads));
    costs.push_back({.preset = name, .stages = {}, .unknown = {}});
  }
  for (const StageNode& node : graph.nodes) {
    const CostAnswer answer = stage_costs(node, terms);
    for (size_t i = 0; i < costs.size(); ++i) {
      PresetCost& sum = costs[i];
      if (answer.costs.empty()) {
        sum.stages.push_back({node.name, std::nullopt});
        sum.unknown.push_back(fmt::format("{} ({})", node.name, answer.problem));
        continue;
      }
      const StageCost& cost = answer.costs[i];
      sum.stages.push_back({node.name, cost});
      sum.seconds += cost.seconds(threads);
      sum.memory = std::max(sum.memory, cost.memory_bytes);
      sum.disk += cost.disk_bytes;
    }
  }
  std::sort(costs.begin(), costs.end(), [](const PresetCost& a, const PresetCost& b) { return a.seconds < b.seconds; });
  return costs;
}

nlohmann::ordered_json costs_json(const std::vector<PresetCost>& costs, int threads) {
  Json j{{"threads", threads}, {"presets", Json::array()}};
  for (const PresetCost& c : costs) {
    Json stages = Json::object();
    for (const auto& [name, stage] : c.stages)
      stages[name] = stage ? Json{{"seconds", stage->seconds(threads)},
                                  {"cpu_seconds", stage->cpu_s},
                                  {"memory_bytes", stage->memory_bytes},
                                  {"disk_bytes", stage->disk_bytes}}
                           : Json();
    j["presets"].push_back({{"preset", c.preset},
                            {"seconds", c.seconds},
                            {"memory_bytes", c.memory},
                            {"disk_bytes", c.disk},
                            {"stages", std::move(stages)}});
  }
  return j;
}

}  // namespace vitrine
