// A scene as edits see it: what the stages left, and which of it is still there. Read once, changed in place, written as a folder
// that stands for their artifacts (optimize with refine, mesh, decompose).
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/mesh/tri_mesh.h"
#include "core/picture/decomposed_materials.h"
#include "core/picture/trained_scene.h"
#include "core/shape/shape_set.h"

namespace vitrine {

struct EditFolders {
  std::filesystem::path optimize, mesh;
  std::optional<std::filesystem::path> refine = {}, decompose = {};
};

// Flags: 0 or 1 for each.
struct Parts {
  std::vector<uint8_t> diffuse, transmittance;  // surfels
  std::vector<uint8_t> vertices, faces;         // of the mesh
  std::vector<uint8_t> walls;                   // vertices of the surroundings
  std::vector<uint8_t> content;                 // vertices of the mesh of what stands behind glass
};

struct EditScene {
  TrainedScene trained;
  std::optional<DecomposedMaterials> materials;  // of trained.surfels
  TriMesh mesh, surroundings;                    // the latter: walls that the decompose stage found, or empty
  TriMesh content;                               // what stands behind glass (the mesh stage's behind_glass.ply), or empty
  Parts there;                                   // what no edit has deleted

  bool shows_sky(size_t surfel) const { return materials && materials->shows_sky(surfel); }
};

// Whether a surfel of the diffuse layer shows this shape, which goes with most of those that do.
bool shows_shape(const ShapeSet::Entry& entry, const SplatLayer& surfels, size_t i);

// Throws Error{Input} with file and cause, also when the files do not belong together.
EditScene read_edit_scene(const EditFolders& folders);
// Without what was deleted; solid glass loses the part of its shell that lay on deleted faces of the mesh. Files that no edit
// touches (views, light of the photos) are copied.
void write_edit_scene(const EditScene& scene, const EditFolders& from, const std::filesystem::path& folder);

}  // namespace vitrine
