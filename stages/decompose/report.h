// decompose/report.json, but for what is said of polished things.
#pragma once

#include <optional>

#include "core/base/json.h"
#include "stages/decompose/decompose.h"
#include "stages/decompose/light_solver.h"
#include "stages/decompose/wall_extension.h"

namespace vitrine {

struct FoundLight {
  const DecomposeConfig& config;
  const std::vector<LitPoint>& points;
  const std::vector<bool>& usable;
  size_t solved_with = 0;  // of the points
  double voxel = 0;
  const LightSolution& solution;
  const Surroundings& around;
  size_t shell_faces = 0;
  float sky_distance = 0;
  const ExtendedWalls& walls;
  std::optional<float> horizon;  // sine of the elevation from which on a mirror shows sky
  bool card_beside = false;      // the scale is that of a card beside the trained scene
};

nlohmann::ordered_json report_of(const FoundLight& found);

}  // namespace vitrine
