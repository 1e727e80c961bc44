// The figures of one run that are compared, and where eval/metrics.json has them.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>

#include "core/foundation/base/json.h"

namespace vitrine {

using Figures = std::map<std::string, double>;  // a figure that was not measured is absent

struct FigureKind {
  const char* name;   // "glass"
  const char* path;   // "regions.transparent.psnr"; empty: not of metrics.json
  const char* title;  // of a column
  int digits;
  bool more_is_better;
  bool column;  // stands in the table; the others are kept in files alone
};
std::span<const FigureKind> figure_kinds();

// Figures of single objects, pooled PSNR: this, the role, a space, the name. Of no kind: scenes have different objects.
inline constexpr std::string_view kObjectFigure = "object: ";

inline constexpr const char* kCpuFigure = "cpu_s";  // of the training alone

// Of eval/metrics.json. Where the truth knows no coats, `mirror` is the region `reflective`: specular and not glass.
Figures figures_of(const nlohmann::json& metrics);

}  // namespace vitrine
