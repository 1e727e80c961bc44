// edit: changes materials of a finished scene or deletes parts of it, selected by mask class, object, box, marks in photos or
// mesh component. Started by `vitrine edit`; not part of the graph of `vitrine run`. The originals are only read: the same list
// gives the same scene, and another list starts from the originals again.
//   reads   sfm (cameras), optimize, mesh; refine, decompose, masks if they exist; edits: a YAML file (below)
//   writes  edited/{gaussians,optimize,mesh,decompose}: a folder that can replace those artifacts;
//           edited/edits.yaml (the list), edited/report.json (selection of each edit; the mesh's components)
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/render/edit/selection.h"
#include "core/scene/camera/view.h"
#include "stages/stage.h"

namespace vitrine {

struct EditConfig {};
void describe(Describer& d, EditConfig& c);

void run_edit(const EditConfig& config, StageContext& context);
Stage edit_stage();

// List of edits of a finished scene: a YAML file, applied in order. README.md documents the format.
//
//   edits:
//     - name: golden vase
//       select: {class: specular, except: {class: transparent}}
//       set: {tint: 0.05, f0: [1, 0.77, 0.34], k_s: 0.05, roughness: 0.1}
//     - select: {box: [-0.2, -0.1, -0.8, 0.3, 0.4, -0.2]}      # x0 y0 z0 x1 y1 z1 in the scene's frame
//       delete: true

// Mean free path of light below a surface, [length] times colour.
struct Scatter {
  double length = 0;
  bool metres = false;  // else scene units
  Vec3f color{1, 1, 1};
};

// Marks of brushed metal, or of metal turned on a lathe.
struct BrushMarks {
  Vec3f direction{};  // unit: of the marks; or the axis that they run around, through the middle of the selected surfels
  bool turned = false;
  float anisotropy = 0.7f;
};

struct MaterialChange {
  std::optional<Vec3f> tint = {};  // factor of the albedo
  std::optional<Vec3f> f0 = {};
  std::optional<float> roughness = {}, specular_weight = {}, transmission = {};
  std::optional<Scatter> scatter = {};
  std::optional<BrushMarks> marks = {};
};

struct Edit {
  std::string name;    // given by the user, or "edit 3"
  std::string where;   // file:line:col
  std::string wanted;  // description of the selector
  Selector select = {};
  MaterialChange set = {};
  bool remove = false;  // delete the selected parts; `set` is empty then
};

// Photos of marks are looked up in `views`, whose intrinsics have the size of the undistorted photos. Throws Error{Usage} with
// every mistake at its line.
std::vector<Edit> read_edits(const std::filesystem::path& path, std::span<const View> views);

}  // namespace vitrine
