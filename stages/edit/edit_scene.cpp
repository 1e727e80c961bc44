#include "stages/edit/edit_scene.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/mesh_topology.h"
#include "core/scene/kept_surfels.h"
#include "core/scene/scene_io.h"

namespace vitrine {

namespace {

template <class T>
std::vector<T> remaining(const std::vector<T>& values, const std::vector<uint8_t>& keep) {
  std::vector<T> out;
  for (size_t i = 0; i < values.size(); ++i)
    if (keep[i]) out.push_back(values[i]);
  return out;
}

RelightMaterials remaining(const RelightMaterials& m, const std::vector<uint8_t>& keep) {
  return {remaining(m.albedo, keep), remaining(m.roughness, keep), remaining(m.f0, keep), remaining(m.specular_weight, keep),
          remaining(m.transmission, keep)};
}

// Faces of the surroundings whose corners are all there.
std::vector<uint8_t> whole_faces(const TriMesh& mesh, const std::vector<uint8_t>& vertices) {
  std::vector<uint8_t> keep(mesh.faces.size());
  for (size_t f = 0; f < keep.size(); ++f)
    keep[f] = std::ranges::all_of(mesh.faces[f], [&](uint32_t v) { return vertices[v] != 0; });
  return keep;
}

}  // namespace

EditScene read_edit_scene(const EditFolders& folders) {
  EditScene scene;
  scene.trained = read_trained_scene(folders.optimize, folders.refine);
  scene.mesh = read_mesh_ply(folders.mesh / "mesh" / "mesh.ply");
  if (scene.mesh.faces.empty())
    throw Error(ErrorKind::Input, "the mesh is empty",
                {.where = (folders.mesh / "mesh" / "mesh.ply").string(),
                 .hint = "run the stage mesh again, with other options",
                 .code = "EMPTY_MESH"});
  if (folders.relight) {
    scene.materials = read_relight_materials(*folders.relight);
    if (scene.materials->size() != scene.trained.surfels.diffuse.size())
      throw Error(
          ErrorKind::Input, "the materials belong to another scene",
          {.where = relight_materials_path(*folders.relight).string(),
           .why = fmt::format("{} materials for {} surfels", scene.materials->size(), scene.trained.surfels.diffuse.size()),
           .hint = "run the relight stage again",
           .code = "BAD_MATERIALS"});
    const fs::path walls = relight_surroundings_path(*folders.relight);
    std::error_code ec;
    if (fs::exists(walls, ec)) scene.surroundings = read_mesh_ply(walls);
  }
  scene.there.diffuse.assign(scene.trained.surfels.diffuse.size(), 1);
  scene.there.transmittance.assign(scene.trained.surfels.transmittance.size(), 1);
  scene.there.vertices.assign(scene.mesh.positions.size(), 1);
  scene.there.faces.assign(scene.mesh.faces.size(), 1);
  scene.there.walls.assign(scene.surroundings.positions.size(), 1);
  return scene;
}

void write_edit_scene(const EditScene& scene, const EditFolders& from, const fs::path& folder) {
  for (const char* sub : {"gaussians", "optimize", "mesh"}) make_folders(folder / sub);
  const SplatScene& surfels = scene.trained.surfels;
  const auto write = [&](const SplatLayer& layer) {
    if (layer.size() > 0) write_layer(folder / "gaussians" / fmt::format("{}.ply", name(layer.kind())), layer);
  };
  write(kept_surfels(surfels.diffuse, scene.there.diffuse));
  write(surfels.reflection);
  write(kept_surfels(surfels.transmittance, scene.there.transmittance));
  write_mesh_ply(folder / "mesh" / "mesh.ply", submesh(scene.mesh, scene.there.faces));
  const auto copy = [&](const fs::path& source, const fs::path& relative) {
    std::error_code ec;
    if (fs::exists(source / relative, ec)) write_file(folder / relative, read_file(source / relative));
  };
  write_image_options(folder / "optimize" / "model.json", scene.trained.image);
  copy(from.optimize, fs::path("optimize") / "views.json");
  if (!from.relight) return;
  write_relight_materials(folder, remaining(*scene.materials, scene.there.diffuse));
  copy(*from.relight, fs::path("relight") / "environment.exr");
  const TriMesh walls = submesh(scene.surroundings, whole_faces(scene.surroundings, scene.there.walls));
  if (!walls.faces.empty()) write_mesh_ply(relight_surroundings_path(folder), walls);
}

}  // namespace vitrine
