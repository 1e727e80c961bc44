// Stage `objects`: the table of objects, everything that is not plain opaque, found once for all later stages (README.md).
//   reads   sfm (cameras, photos), masks; optionally a table that a person corrected
//   writes  objects/objects.json (core/scene/objects), objects/labels/<photo>.png, objects/shape_<i>.ply (of shapes that are meshes),
//           objects/shapes.ply (all of them, to look at), objects/contact_sheet.png
#pragma once

#include <string>

#include "stages/stage.h"

namespace vitrine {

// Auto: the given table, else Fitted. Fitted: shapes fitted to the masks. None: masks alone.
enum class ObjectSource { Auto, Fitted, None };

struct ObjectsConfig {
  ObjectSource source = ObjectSource::Auto;
  int max_side = 480;
  int hull_voxels = 128;  // along the longest side of the visual hull; no option: tests with small masks take fewer
  double coat_below = 0.3;
  int holdout_every = 8;
};
void describe(Describer& d, ObjectsConfig& c);

void run_objects(const ObjectsConfig& config, StageContext& context);
Stage objects_stage();
StageCost objects_cost(const CostTerms& terms);
StageReport objects_report();

// "objects.json" of a folder with meshes beside it means the folder; any other path itself.
std::filesystem::path meant_objects(const std::filesystem::path& path);

}  // namespace vitrine
