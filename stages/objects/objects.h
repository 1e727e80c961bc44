// Stage `objects`: the table of all objects that are not plain opaque, detected once for all later stages (README.md).
//   reads   sfm (cameras, photos), masks; optionally a table that a person corrected
//   writes  objects/objects.json (core/scene/objects), objects/labels/<photo>.png, objects/shape_<i>.ply (of shapes that are
//   meshes),
//           objects/shapes.ply (all shapes, for viewing), objects/contact_sheet.png
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/image.h"
#include "core/scene/objects/object_labels.h"
#include "core/scene/objects/object_set.h"
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

// Label images (core/scene/objects/object_labels.h): the object of each marked pixel.

// Objects for marked pixels that show no shape and are not next to one: glass and specular surfaces whose position the photos do
// not determine.
struct UnlocatedObjects {
  uint16_t glass = 0, specular = 0;
};

// Labels of one photo at mask size. `masks`: artifact of the masks stage. A pixel of a class belongs to the nearest object of
// that class on its ray; without a hit, to the object within three of 240 pixels. The transparent mask is in front of the
// specular one. Empty: the photo has no mask of either class.
Image16 labelled_pixels(const std::filesystem::path& masks, const View& photo, const ObjectSet& set,
                        const UnlocatedObjects& unlocated);

// Contact sheet of the objects for visual inspection: some photos with labels, names, and silhouettes of the shapes.

// Glass is blue, mirrors orange, coats green; guessed objects are paler.
void write_contact_sheet(const std::filesystem::path& file, const std::filesystem::path& sfm, const ViewSet& views,
                         const LabelledObjects& objects);

}  // namespace vitrine
