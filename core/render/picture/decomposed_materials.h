// Materials estimated by the decompose stage: those of gaussians/diffuse.ply and the albedo of gaussians/transmittance.ply, in
// the same order. The file is a binary PLY of floats with these elements, properties in the order of the members below; the
// second element exists if the scene has a transmittance layer:
//   vertex         albedo_r albedo_g albedo_b roughness f0_r f0_g f0_b specular_weight transmission
//   behind_glass   albedo_r albedo_g albedo_b
// and two that edits add, as long as the first:
//   subsurface     mean_free_path_r mean_free_path_g mean_free_path_b
//   brushed        marks_x marks_y marks_z
// All values are activated: albedo in [0, 1] linear, the others in [0, 1], lengths at least 0. Algorithms 7.1: radiance of a
// diffuse surface = albedo / pi times irradiance, in the units of decompose/environment.exr. A surfel that shows the sky (distant
// light, no surface) reflects nothing: albedo, f0 and specular weight are 0; under another light the environment replaces it.
#pragma once

#include <filesystem>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

struct DecomposedMaterials {
  std::vector<Vec3f> albedo;           // [surfels] linear
  std::vector<float> roughness;        // [surfels] GGX alpha = roughness^2
  std::vector<Vec3f> f0;               // [surfels] reflectance at normal incidence
  std::vector<float> specular_weight;  // [surfels]
  std::vector<float> transmission;     // [surfels]
  // [surfels of the transmittance layer] linear; these surfels are purely diffuse. Empty: unknown.
  std::vector<Vec3f> albedo_behind_glass;
  // [surfels] mean free path below the surface, scene units; 0: opaque. Empty: all are opaque.
  std::vector<Vec3f> scatter;
  // [surfels] direction of the marks of brushed metal times its anisotropy (core/render/relight/microfacet.h). Empty: none is
  // brushed.
  std::vector<Vec3f> marks;

  size_t size() const { return albedo.size(); }  // of the diffuse layer
  bool shows_sky(size_t i) const { return albedo[i] == Vec3f{} && f0[i] == Vec3f{} && specular_weight[i] == 0; }
  void resize(size_t surfels);
};

// Path inside an artifact of the decompose stage.
inline std::filesystem::path decomposed_materials_path(const std::filesystem::path& folder) {
  return folder / "decompose" / "materials.ply";
}
inline std::filesystem::path decomposed_environment_path(const std::filesystem::path& folder) {
  return folder / "decompose" / "environment.exr";
}

// Surroundings of the mesh (walls of the room): triangles with the albedo as vertex colour. They occlude and reflect light. The
// file is missing if the photos show no walls.
inline std::filesystem::path decomposed_surroundings_path(const std::filesystem::path& folder) {
  return folder / "decompose" / "surroundings.ply";
}

// `folder`: an artifact of the decompose stage, or an output folder. Throws Error{Input} with file and cause (missing, truncated,
// other properties, a value that is not in [0, 1]).
DecomposedMaterials read_decomposed_materials(const std::filesystem::path& folder);
// Also throws if the numbers of surfels differ from the scene's.
DecomposedMaterials read_decomposed_materials(const std::filesystem::path& folder, const SplatScene& scene);
void write_decomposed_materials(const std::filesystem::path& folder, const DecomposedMaterials& materials);

}  // namespace vitrine
