#include "tests/bench/optics/record.h"

#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/json.h"

namespace vitrine {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Six digits are more than any figure repeats to.
double short_number(double value) { return std::stod(fmt::format("{:.6g}", value)); }

OrderedJson figures_json(const Figures& figures) {
  OrderedJson out = OrderedJson::object();
  for (const FigureKind& kind : figure_kinds())
    if (const auto it = figures.find(kind.name); it != figures.end()) out[kind.name] = short_number(it->second);
  return out;
}

}  // namespace

std::string optics_record(const OpticsLabel& label, const OpticsSummary& summary) {
  OrderedJson out;
  out["format"] = "vitrine-optics 1";
  out["commit"] = label.commit;
  out["machine"] = {{"cpu", label.cpu}, {"cores", label.cores}};
  out["date"] = label.date;
  out["seeds"] = label.seeds;
  out["training_seeds"] = label.training_seeds;
  out["settings"] = {{"steps", label.steps}, {"surfels", label.surfels}, {"max_side", label.max_side}};
  out["arms"] = OrderedJson::array();
  for (const Arm& arm : label.arms) out["arms"].push_back({{"name", arm.name}, {"options", arm.options}});
  out["scenes"] = OrderedJson::array();
  for (const SceneSummary& scene : summary.scenes) {
    OrderedJson entry = {{"scene", scene.scene}, {"regions", scene.kinds}, {"arms", OrderedJson::object()}};
    for (const ArmFigures& arm : scene.arms) entry["arms"][arm.arm] = figures_json(arm.figures);
    out["scenes"].push_back(std::move(entry));
  }
  out["against"] = summary.first_arm;
  out["gains"] = OrderedJson::array();
  for (const ArmGains& arm : summary.gains) {
    OrderedJson entry = {{"arm", arm.arm}, {"figures", OrderedJson::object()}};
    for (const FigureKind& kind : figure_kinds())
      if (const auto it = arm.gains.find(kind.name); it != arm.gains.end())
        entry["figures"][kind.name] = {{"mean", short_number(it->second.mean)},
                                       {"deviation", short_number(it->second.deviation)},
                                       {"worst", short_number(it->second.worst)},
                                       {"scenes", it->second.scenes}};
    out["gains"].push_back(std::move(entry));
  }
  return readable(out);
}

}  // namespace vitrine
