// What a scene must know to be lit anew: the trained surfels, the materials that the decompose stage found for them, the light
// that it took out of the photos, the mesh that throws the shadows, and the walls around it.
#pragma once

#include <filesystem>
#include <optional>

#include "core/light/environment.h"
#include "core/mesh/tri_mesh.h"
#include "core/picture/decomposed_materials.h"
#include "core/picture/surfel_colors.h"
#include "core/picture/trained_scene.h"
#include "core/relight/microfacet.h"

namespace vitrine {

struct RelitScene {
  TrainedScene trained;
  DecomposedMaterials materials;  // of trained.surfels
  Environment captured;           // the light of the photos
  TriMesh mesh;
  TriMesh behind_glass;  // what stands behind its glass, which `mesh` does not have; may be empty
  TriMesh surroundings;  // walls around it, colours = albedo: they block light and send it on; empty: there are none

  RelitMaterial material(size_t surfel) const {
    return {materials.albedo[surfel], materials.f0[surfel], materials.roughness[surfel], materials.specular_weight[surfel],
            materials.transmission[surfel]};
  }
  LayerBlend blend() const { return trained.image.composite.blend; }
};

// From the artifacts of these stages. Throws Error{Input} with file and cause, also when they do not belong together.
struct RelitFolders {
  std::filesystem::path optimize;
  std::optional<std::filesystem::path> refine = std::nullopt;
  std::filesystem::path mesh, decompose;
};
RelitScene read_relit_scene(const RelitFolders& folders);

// The diffuse surfels with the albedo as colour and the materials of the decompose stage: what the rasteriser blends for a relit
// picture.
SplatLayer material_layer(const RelitScene& scene);

}  // namespace vitrine
