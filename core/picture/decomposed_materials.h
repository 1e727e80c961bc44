// What the decompose stage found for every surfel, freed of the light of the photos: materials of gaussians/diffuse.ply, albedo
// of gaussians/transmittance.ply, in the same order. The file is a binary PLY of two elements, floats in the order of the members
// below; the second is there if the scene has such a layer:
//   vertex         albedo_r albedo_g albedo_b roughness f0_r f0_g f0_b specular_weight transmission
//   behind_glass   albedo_r albedo_g albedo_b
// All are activated values: albedo in [0, 1] linear, the others in [0, 1]. Algorithms 7.1: radiance of a diffuse surface =
// albedo / pi times irradiance, in the units of decompose/environment.exr. A surfel that shows the sky (light from far away, no
// surface) reflects nothing, albedo, f0 and specular weight are 0: under another light that light is seen in its place.
#pragma once

#include <filesystem>
#include <vector>

#include "core/math/vec.h"
#include "core/scene/splat_scene.h"

namespace vitrine {

struct DecomposedMaterials {
  std::vector<Vec3f> albedo;           // [surfels] linear
  std::vector<float> roughness;        // [surfels] GGX alpha = roughness^2
  std::vector<Vec3f> f0;               // [surfels] reflectance head on
  std::vector<float> specular_weight;  // [surfels]
  std::vector<float> transmission;     // [surfels]
  // [surfels of the transmittance layer] linear; they have no gloss. Empty: not known.
  std::vector<Vec3f> albedo_behind_glass;

  size_t size() const { return albedo.size(); }  // of the diffuse layer
  bool shows_sky(size_t i) const { return albedo[i] == Vec3f{} && f0[i] == Vec3f{} && specular_weight[i] == 0; }
  void resize(size_t surfels);
};

// Inside an artifact of the decompose stage.
inline std::filesystem::path decomposed_materials_path(const std::filesystem::path& folder) {
  return folder / "decompose" / "materials.ply";
}
inline std::filesystem::path decomposed_environment_path(const std::filesystem::path& folder) {
  return folder / "decompose" / "environment.exr";
}

// The surroundings of the mesh (walls of the room), as triangles with their albedo as vertex colours: they block light and
// reflect it. Absent where the photos show none.
inline std::filesystem::path decomposed_surroundings_path(const std::filesystem::path& folder) {
  return folder / "decompose" / "surroundings.ply";
}

// `folder`: an artifact of the decompose stage, or an output folder. Throws Error{Input} with file and cause (missing, truncated,
// other properties, a value that is not in [0, 1]).
DecomposedMaterials read_decomposed_materials(const std::filesystem::path& folder);
// Throws also where they are those of another scene: other numbers of surfels.
DecomposedMaterials read_decomposed_materials(const std::filesystem::path& folder, const SplatScene& scene);
void write_decomposed_materials(const std::filesystem::path& folder, const DecomposedMaterials& materials);

}  // namespace vitrine
