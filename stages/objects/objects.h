// Stage `objects`: the table of all objects that are not plain opaque, detected once for all later stages (README.md).
//   reads   sfm (cameras, photos), masks; optionally a table that a person corrected
//   writes  objects/objects.json (core/scene/objects), objects/labels/<photo>.png, objects/shape_<i>.ply (of shapes that are
//   meshes),
//           objects/shapes.ply (all shapes, for viewing), objects/contact_sheet.png
#pragma once

#include <string>

#include "stages/stage.h"

namespace vitrine {

// Auto: the given table, else Fitted. Fitted: shapes fitted to the masks. None: masks alone.
enum class ObjectSource { Auto, Fitted, None };

struct ObjectsConfig {
  ObjectSource source = ObjectSource::Auto;
  int max_side = 480;
  int hull_voxels = 128;  // along the longest side of the visual hull; not an option: tests with small masks use fewer
  double coat_below = 0.3;
  int holdout_every = 8;
};
void describe(Describer& d, ObjectsConfig& c);

void run_objects(const ObjectsConfig& config, StageContext& context);
Stage objects_stage();
StageCost objects_cost(const CostTerms& terms);
StageReport objects_report();

// Returns the folder for an "objects.json" with meshes next to it, otherwise the path itself.
std::filesystem::path meant_objects(const std::filesystem::path& path);

}  // namespace vitrine
