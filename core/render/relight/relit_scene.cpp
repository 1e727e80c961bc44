#include "core/render/relight/relit_scene.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

// Clamp of values before the inverse sigmoid, which diverges at 0 and 1; the difference is invisible.
constexpr float kOpenEnd = 1e-4f;

constexpr float kInvisible = -20;  // raw opacity

float raw(float value) { return logit(std::clamp(value, kOpenEnd, 1 - kOpenEnd)); }

}  // namespace

RelitScene read_relit_scene(const RelitFolders& folders) {
  RelitScene scene;
  scene.trained = read_trained_scene(folders.optimize, folders.refine);
  scene.materials = read_decomposed_materials(folders.decompose, scene.trained.surfels);
  scene.captured = read_environment(decomposed_environment_path(folders.decompose));
  const fs::path mesh = folders.mesh / "mesh" / "mesh.ply";
  scene.mesh = read_mesh_ply(mesh);
  if (scene.mesh.faces.empty())
    throw Error(ErrorKind::Input, "the mesh is empty: nothing would throw a shadow",
                {.where = mesh.string(), .hint = "run the stage mesh again, with other options", .code = "EMPTY_MESH"});
  std::error_code ec;
  if (const fs::path content = folders.mesh / "mesh" / "behind_glass.ply"; fs::exists(content, ec))
    scene.behind_glass = read_mesh_ply(content);
  const fs::path around = decomposed_surroundings_path(folders.decompose);
  if (fs::exists(around, ec)) {
    scene.surroundings = read_mesh_ply(around);
    if (scene.surroundings.colors.size() != scene.surroundings.positions.size())
      throw Error(ErrorKind::Input, "the surroundings have no albedo",
                  {.where = around.string(),
                   .why = "no vertex colours",
                   .hint = "run the stage decompose again",
                   .code = "BAD_MATERIALS"});
  }
  return scene;
}

SplatLayer material_layer(const RelitScene& scene) {
  SplatLayer out = painted_layer(scene.trained.surfels.diffuse, scene.materials.albedo);
  for (size_t i = 0; i < out.size(); ++i) {
    const RelitMaterial m = scene.material(i);
    for (size_t c = 0; c < 3; ++c) out.at(Attribute::F0, i)[c] = raw(m.f0[c]);
    if (scene.materials.shows_sky(i)) *out.at(Attribute::Opacity, i) = kInvisible;
    *out.at(Attribute::Roughness, i) = raw(m.roughness);
    *out.at(Attribute::SpecularWeight, i) = raw(m.specular);
    *out.at(Attribute::Transmission, i) = raw(m.transmission);
  }
  return out;
}

}  // namespace vitrine
