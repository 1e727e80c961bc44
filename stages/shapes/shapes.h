// Stage `shapes`: the planes, boxes and surfaces of revolution that glass and polished metal have, found once for all
// later stages (README.md).
//   reads   sfm (cameras, photos), masks; optionally a file of shapes that a person corrected
//   writes  shapes/shapes.json, shapes/shape_<i>.ply (of entries that are meshes), shapes/shapes.ply (all of them, to look at),
//           shapes/contact_sheet.png
#pragma once

#include <string>

#include "stages/stage.h"

namespace vitrine {

struct ShapesConfig {
  std::string source = "auto";
  int max_side = 480;
  int resolution = 128;
  double dissent = 0.1;
  bool free_form = true;
  double coat_below = 0.3;
  int holdout_every = 8;
};
void describe(Describer& d, ShapesConfig& c);

void run_shapes(const ShapesConfig& config, StageContext& context);
Stage shapes_stage();
StageCost shapes_cost(const CostTerms& terms);
StageReport shapes_report();

// "shapes.json" of a folder with meshes beside it means the folder; any other path itself.
std::filesystem::path meant_shapes(const std::filesystem::path& path);

}  // namespace vitrine
