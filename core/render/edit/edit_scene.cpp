#include "core/render/edit/edit_scene.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/render/model/thick_glass.h"
#include "core/scene/mesh/mesh_distance.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/shape/shape_set.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

namespace {

constexpr double kOnShape = 1.7;  // maximum distance to a shape, in units of its tolerance
constexpr size_t kShellFaces = 256;

template <class T>
std::vector<T> remaining(const std::vector<T>& values, const std::vector<uint8_t>& keep) {
  std::vector<T> out;
  for (size_t i = 0; i < values.size(); ++i)
    if (keep[i]) out.push_back(values[i]);
  return out;
}

DecomposedMaterials remaining(const DecomposedMaterials& m, const Parts& keep) {
  return {.albedo = remaining(m.albedo, keep.diffuse),
          .roughness = remaining(m.roughness, keep.diffuse),
          .f0 = remaining(m.f0, keep.diffuse),
          .specular_weight = remaining(m.specular_weight, keep.diffuse),
          .transmission = remaining(m.transmission, keep.diffuse),
          .albedo_behind_glass = remaining(m.albedo_behind_glass, keep.transmittance),
          .scatter = m.scatter.empty() ? m.scatter : remaining(m.scatter, keep.diffuse),
          .marks = m.marks.empty() ? m.marks : remaining(m.marks, keep.diffuse)};
}

// Keeps a shape while at least half of its surfels remain: mirrors, coats, thin glass. Thin glass without surfels is kept.
// Attached shapes are removed with the shape they are attached to.
std::shared_ptr<const ShapeSet> remaining(std::shared_ptr<const ShapeSet> set, const SplatLayer& surfels,
                                          const std::vector<uint8_t>& keep) {
  if (!set || std::ranges::all_of(keep, [](uint8_t there) { return there != 0; })) return set;
  std::vector<uint8_t> stays;
  for (const ShapeSet::Entry& e : set->entries) {
    size_t all = 0, left = 0;
    for (size_t i = 0; i < surfels.size(); ++i) {
      if (!shows_shape(e, surfels, i)) continue;
      ++all, left += keep[i];
    }
    stays.push_back(all > 0 ? 2 * left >= all : is_glass(e.role));
  }
  ShapeSet out = set->kept(stays);
  return out.entries.empty() ? nullptr : std::make_shared<const ShapeSet>(std::move(out));
}

fs::path behind_glass_path(const fs::path& mesh) { return mesh / "mesh" / "behind_glass.ply"; }

// The glass wall was smoothed from the mesh: each of its faces follows its nearest mesh face.
std::shared_ptr<const ThickGlass> remaining(std::shared_ptr<const ThickGlass> glass, const TriMesh& mesh,
                                            const std::vector<uint8_t>& faces) {
  if (!glass || std::ranges::all_of(faces, [](uint8_t there) { return there != 0; })) return glass;
  const MeshDistance places(mesh);
  const TriMesh& shell = glass->mesh();
  std::vector<uint8_t> keep(shell.faces.size());
  parallel_for(keep.size(), kShellFaces, [&](size_t f) {
    const auto& v = shell.faces[f];
    keep[f] = faces[places.closest((shell.positions[v[0]] + shell.positions[v[1]] + shell.positions[v[2]]) / 3.f).face];
  });
  TriMesh left = submesh(shell, keep);
  if (left.faces.empty()) return nullptr;
  return std::make_shared<const ThickGlass>(std::move(left), glass->ior(), glass->tolerance());
}

// Faces that keep all their vertices.
std::vector<uint8_t> whole_faces(const TriMesh& mesh, const std::vector<uint8_t>& vertices) {
  std::vector<uint8_t> keep(mesh.faces.size());
  for (size_t f = 0; f < keep.size(); ++f)
    keep[f] = std::ranges::all_of(mesh.faces[f], [&](uint32_t v) { return vertices[v] != 0; });
  return keep;
}

}  // namespace

bool shows_shape(const ShapeSet::Entry& entry, const SplatLayer& surfels, size_t i) {
  if (entry.role == ShapeRole::Mirror && *surfels.at(Attribute::SpecularWeight, i) < 0) return false;  // k_s < 1/2
  if (is_glass(entry.role) && *surfels.at(Attribute::Transmission, i) < 0) return false;               // tau < 1/2
  const float* m = surfels.at(Attribute::Mean, i);
  const Vec3d p{m[0], m[1], m[2]};
  return length(nearest(entry.shape, p).position - p) <= kOnShape * entry.tolerance;
}

void EditScene::keep_all() {
  there.diffuse.assign(trained.surfels.diffuse.size(), 1);
  there.transmittance.assign(trained.surfels.transmittance.size(), 1);
  there.vertices.assign(mesh.positions.size(), 1);
  there.faces.assign(mesh.faces.size(), 1);
  there.walls.assign(surroundings.positions.size(), 1);
  there.content.assign(content.positions.size(), 1);
}

EditScene read_edit_scene(const EditFolders& folders) {
  EditScene scene;
  scene.trained = read_trained_scene(folders.optimize, folders.refine);
  scene.mesh = read_mesh_ply(folders.mesh / "mesh" / "mesh.ply");
  if (scene.mesh.faces.empty())
    throw Error(ErrorKind::Input, "the mesh is empty",
                {.where = (folders.mesh / "mesh" / "mesh.ply").string(),
                 .hint = "run the stage mesh again, with other options",
                 .code = "EMPTY_MESH"});
  if (folders.decompose) {
    scene.materials = read_decomposed_materials(*folders.decompose, scene.trained.surfels);
    const fs::path walls = decomposed_surroundings_path(*folders.decompose);
    std::error_code ec;
    if (fs::exists(walls, ec)) scene.surroundings = read_mesh_ply(walls);
  }
  if (const fs::path content = behind_glass_path(folders.mesh); fs::exists(content)) scene.content = read_mesh_ply(content);
  scene.keep_all();
  return scene;
}

EditScene kept(EditScene scene) {
  const Parts keep = std::move(scene.there);
  SplatScene& surfels = scene.trained.surfels;
  ImageOptions& image = scene.trained.image;
  image.transmission.thick = remaining(image.transmission.thick, scene.mesh, keep.faces);
  image.shape.set = remaining(image.shape.set, surfels.diffuse, keep.diffuse);
  if (image.panes.mirrored < keep.diffuse.size())
    image.panes.mirrored = static_cast<size_t>(
        std::count(keep.diffuse.begin(), keep.diffuse.begin() + static_cast<ptrdiff_t>(image.panes.mirrored), 1));
  surfels.diffuse = kept_surfels(surfels.diffuse, keep.diffuse);
  surfels.transmittance = kept_surfels(surfels.transmittance, keep.transmittance);
  if (scene.materials) scene.materials = remaining(*scene.materials, keep);
  scene.mesh = submesh(scene.mesh, keep.faces);
  scene.content = submesh(scene.content, whole_faces(scene.content, keep.content));
  scene.surroundings = submesh(scene.surroundings, whole_faces(scene.surroundings, keep.walls));
  scene.keep_all();
  return scene;
}

void write_edit_scene(const EditScene& scene, const EditFolders& from, const fs::path& folder) {
  for (const char* sub : {"gaussians", "optimize", "mesh"}) make_folders(folder / sub);
  const SplatScene& surfels = scene.trained.surfels;
  for (const LayerKind kind : kAllLayers)
    if (const SplatLayer& layer = surfels.layer(kind); layer.size() > 0)
      write_layer(folder / "gaussians" / fmt::format("{}.ply", name(kind)), layer);
  if (surfels.opaque.size() > 0) write_layer(folder / "gaussians" / "opaque.ply", surfels.opaque);
  write_mesh_ply(folder / "mesh" / "mesh.ply", scene.mesh);
  if (!scene.content.faces.empty()) write_mesh_ply(behind_glass_path(folder), scene.content);
  const auto copy = [&](const fs::path& source, const fs::path& relative) {
    std::error_code ec;
    if (fs::exists(source / relative, ec)) write_file(folder / relative, read_file(source / relative));
  };
  write_image_options(folder / "optimize" / "model.json", scene.trained.image);
  copy(from.optimize, fs::path("optimize") / "views.json");
  if (!scene.materials) return;
  write_decomposed_materials(folder, *scene.materials);
  copy(*from.decompose, fs::path("decompose") / "environment.exr");
  if (!scene.surroundings.faces.empty()) write_mesh_ply(decomposed_surroundings_path(folder), scene.surroundings);
}

}  // namespace vitrine
