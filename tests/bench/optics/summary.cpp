#include "tests/bench/optics/summary.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace vitrine {
namespace {

template <class T>
T& entry_of(std::vector<T>& all, std::string T::*name, const std::string& wanted) {
  const auto it = std::ranges::find(all, wanted, name);
  if (it != all.end()) return *it;
  all.emplace_back().*name = wanted;
  return all.back();
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (double v : values) sum += v;
  return sum / double(values.size());
}

std::string kinds_of(const std::vector<ArmFigures>& arms) {
  std::string kinds;
  for (const char* kind : {"glass", "mirror", "coated"})
    if (std::ranges::any_of(arms, [&](const ArmFigures& a) { return a.figures.contains(kind); }))
      kinds += (kinds.empty() ? "" : " ") + std::string(kind);
  return kinds.empty() ? "none" : kinds;
}

Figures mean_over_seeds(const std::vector<OpticsResult>& results, const std::string& scene, const std::string& arm) {
  std::map<std::string, std::vector<double>> values;
  for (const OpticsResult& r : results)
    if (r.scene == scene && r.arm == arm)
      for (const auto& [name, value] : r.figures) values[name].push_back(value);
  Figures figures;
  for (const auto& [name, all] : values) figures[name] = mean_of(all);
  return figures;
}

Gain gain_of(const std::vector<double>& scenes, bool more_is_better) {
  Gain gain;
  gain.scenes = int(scenes.size());
  gain.mean = mean_of(scenes);
  gain.worst = more_is_better ? *std::ranges::min_element(scenes) : *std::ranges::max_element(scenes);
  if (scenes.size() < 2) return gain;
  double squares = 0;
  for (double v : scenes) squares += (v - gain.mean) * (v - gain.mean);
  gain.deviation = std::sqrt(squares / double(scenes.size() - 1));
  gain.counts = (more_is_better ? gain.mean : -gain.mean) > gain.deviation;
  return gain;
}

std::map<std::string, Gain> gains_of(const std::vector<OpticsResult>& results, const std::vector<SceneSummary>& scenes,
                                     const std::string& arm, const std::string& first) {
  std::map<std::string, Gain> gains;
  for (const FigureKind& kind : figure_kinds()) {
    std::vector<double> of_scenes;
    for (const SceneSummary& scene : scenes) {
      std::vector<double> pairs;
      for (const OpticsResult& a : results)
        for (const OpticsResult& b : results) {
          if (a.scene != scene.scene || b.scene != scene.scene || a.arm != arm || b.arm != first) continue;
          if (a.training_seed != b.training_seed || !a.figures.contains(kind.name) || !b.figures.contains(kind.name)) continue;
          pairs.push_back(a.figures.at(kind.name) - b.figures.at(kind.name));
        }
      if (!pairs.empty()) of_scenes.push_back(mean_of(pairs));
    }
    if (!of_scenes.empty()) gains[kind.name] = gain_of(of_scenes, kind.more_is_better);
  }
  return gains;
}

// Columns as wide as their widest cell: the first two to the left, numbers to the right.
std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  constexpr size_t kWords = 2;
  std::vector<size_t> widths;
  for (const auto& row : rows)
    for (size_t c = 0; c < row.size(); ++c) {
      if (c >= widths.size()) widths.push_back(0);
      widths[c] = std::max(widths[c], row[c].size());
    }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (size_t c = 0; c < row.size(); ++c)
      line += (c == 0 ? "" : "  ") +
              (c < kWords ? fmt::format("{:<{}}", row[c], widths[c]) : fmt::format("{:>{}}", row[c], widths[c]));
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::vector<const FigureKind*> columns_of(const OpticsSummary& summary) {
  std::vector<const FigureKind*> columns;
  for (const FigureKind& kind : figure_kinds()) {
    bool measured = false;
    for (const SceneSummary& scene : summary.scenes)
      for (const ArmFigures& arm : scene.arms) measured |= arm.figures.contains(kind.name);
    if (kind.column && measured) columns.push_back(&kind);
  }
  return columns;
}

// A row for each object of each scene: the figure of the first arm, and what the others gain.
std::vector<std::vector<std::string>> object_rows(const OpticsSummary& summary) {
  std::vector<std::vector<std::string>> rows(1, {"scene", "object", summary.first_arm});
  for (const ArmGains& arm : summary.gains) rows[0].push_back(arm.arm);
  for (const SceneSummary& scene : summary.scenes) {
    const auto first = std::ranges::find(scene.arms, summary.first_arm, &ArmFigures::arm);
    if (first == scene.arms.end()) continue;
    for (const auto& [name, value] : first->figures) {
      if (!name.starts_with(kObjectFigure)) continue;
      auto& row = rows.emplace_back(
          std::vector<std::string>{scene.scene, name.substr(kObjectFigure.size()), fmt::format("{:.2f}", value)});
      for (const ArmGains& gains : summary.gains) {
        const auto arm = std::ranges::find(scene.arms, gains.arm, &ArmFigures::arm);
        const bool measured = arm != scene.arms.end() && arm->figures.contains(name);
        row.push_back(measured ? fmt::format("{:+.2f}", arm->figures.at(name) - value) : "-");
      }
    }
  }
  return rows;
}

}  // namespace

OpticsSummary summary_of(const std::vector<OpticsResult>& results, const std::string& first_arm) {
  OpticsSummary summary{first_arm, {}, {}};
  for (const OpticsResult& r : results) {
    ArmFigures& arm = entry_of(entry_of(summary.scenes, &SceneSummary::scene, r.scene).arms, &ArmFigures::arm, r.arm);
    if (arm.figures.empty()) arm.figures = mean_over_seeds(results, r.scene, r.arm);
    if (r.arm != first_arm) entry_of(summary.gains, &ArmGains::arm, r.arm);
  }
  for (SceneSummary& scene : summary.scenes) scene.kinds = kinds_of(scene.arms);
  for (ArmGains& arm : summary.gains) arm.gains = gains_of(results, summary.scenes, arm.arm, first_arm);
  return summary;
}

std::string summary_text(const OpticsSummary& summary) {
  const std::vector<const FigureKind*> columns = columns_of(summary);
  std::vector<std::vector<std::string>> rows(1, {"scene (regions)", "arm"});
  for (const FigureKind* kind : columns) rows[0].emplace_back(kind->title);
  for (const SceneSummary& scene : summary.scenes)
    for (const ArmFigures& arm : scene.arms) {
      const bool first = &arm == &scene.arms.front();
      auto& row =
          rows.emplace_back(std::vector<std::string>{first ? fmt::format("{} ({})", scene.scene, scene.kinds) : "", arm.arm});
      for (const FigureKind* kind : columns) {
        const auto it = arm.figures.find(kind->name);
        row.push_back(it == arm.figures.end() ? "-" : fmt::format("{:.{}f}", it->second, kind->digits));
      }
    }
  std::string text =
      "PSNR of held-out views in dB, of regions and objects pooled over all pixels; c. = local correlation, n. = "
      "normals in degrees; mean over training seeds\n\n" +
      aligned(rows);
  if (summary.gains.empty()) return text;
  rows.assign(1, {"arm", fmt::format("minus {}", summary.first_arm)});
  for (const FigureKind* kind : columns) rows[0].emplace_back(kind->title);
  for (const ArmGains& arm : summary.gains)
    for (const char* what : {"mean", "deviation", "worst", "scenes", "counts"}) {
      const std::string_view line = what;
      auto& row = rows.emplace_back(std::vector<std::string>{line == "mean" ? arm.arm : "", what});
      for (const FigureKind* kind : columns) {
        const auto it = arm.gains.find(kind->name);
        if (it == arm.gains.end()) {
          row.emplace_back("-");
          continue;
        }
        const Gain& gain = it->second;
        if (line == "scenes")
          row.push_back(std::to_string(gain.scenes));
        else if (line == "counts")
          row.emplace_back(gain.counts ? "yes" : "no");
        else if (line == "deviation")
          row.push_back(gain.scenes < 2 ? "-" : fmt::format("{:.{}f}", gain.deviation, kind->digits));
        else
          row.push_back(fmt::format("{:+.{}f}", line == "mean" ? gain.mean : gain.worst, kind->digits));
      }
    }
  text += "\nDifferences over scenes; counts = the mean is an improvement larger than the deviation\n\n" + aligned(rows);
  if (rows = object_rows(summary); rows.size() > 1) text += "\nPooled PSNR of each object, and differences\n\n" + aligned(rows);
  return text;
}

}  // namespace vitrine
