// Editable scene: the outputs of the stages, with flags for the parts that remain. Read once, changed in memory, written as a
// folder that replaces the artifacts of optimize (with refine), mesh and decompose.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {

struct EditFolders {
  std::filesystem::path optimize, mesh;
  std::optional<std::filesystem::path> refine = {}, decompose = {};
};

// Flags, 0 or 1.
struct Parts {
  std::vector<uint8_t> diffuse, transmittance;  // surfels
  std::vector<uint8_t> vertices, faces;         // of the mesh
  std::vector<uint8_t> walls;                   // vertices of the surroundings mesh
  std::vector<uint8_t> content;                 // vertices of the mesh behind glass
};

struct EditScene {
  TrainedScene trained;
  std::optional<DecomposedMaterials> materials;  // of trained.surfels
  TriMesh mesh, surroundings;                    // surroundings: walls from the decompose stage, or empty
  TriMesh content;                               // surfaces behind glass (behind_glass.ply of the mesh stage), or empty
  Parts there;                                   // 1: not deleted by an edit

  void keep_all();  // sets all flags
  bool shows_sky(size_t surfel) const { return materials && materials->shows_sky(surfel); }
};

// Whether diffuse surfel `i` represents this shape. A shape is deleted with the majority of these surfels.
bool shows_shape(const ShapeSet::Entry& entry, const SplatLayer& surfels, size_t i);

// Throws Error{Input} with file and cause, also when the files belong to different scenes.
EditScene read_edit_scene(const EditFolders& folders);
// The remaining parts. Solid glass loses the part of its glass wall that lies on deleted mesh faces. The reflection layer and the
// opaque twin stay as they are.
EditScene kept(EditScene scene);
// Writes all parts, whatever the flags. Files that edits do not change (views, light of the photos) are copied.
void write_edit_scene(const EditScene& scene, const EditFolders& from, const std::filesystem::path& folder);

}  // namespace vitrine
