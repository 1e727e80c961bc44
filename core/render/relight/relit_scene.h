// Input of relighting: the trained surfels, their materials and the light of the photos (decompose stage), the mesh that casts
// shadows, and the walls around it.
#pragma once

#include <filesystem>
#include <optional>

#include "core/scene/light/environment.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/surfel_colors.h"
#include "core/render/picture/trained_scene.h"
#include "core/render/relight/microfacet.h"

namespace vitrine {

struct RelitScene {
  TrainedScene trained;
  DecomposedMaterials materials;  // of trained.surfels
  Environment captured;           // the light of the photos
  TriMesh mesh;
  TriMesh behind_glass;  // surfaces behind its glass, not part of `mesh`; may be empty
  TriMesh surroundings;  // walls, vertex colours = albedo; they occlude and reflect light; may be empty

  RelitMaterial material(size_t surfel) const {
    return {materials.albedo[surfel], materials.f0[surfel], materials.roughness[surfel], materials.specular_weight[surfel],
            materials.transmission[surfel]};
  }
  LayerBlend blend() const { return trained.image.composite.blend; }
};

// Artifacts of these stages. The reader throws Error{Input} with file and cause, also when they belong to different scenes.
struct RelitFolders {
  std::filesystem::path optimize;
  std::optional<std::filesystem::path> refine = std::nullopt;
  std::filesystem::path mesh, decompose;
};
RelitScene read_relit_scene(const RelitFolders& folders);

// The diffuse surfels with albedo as colour and the materials of the decompose stage, as the rasteriser blends them for a relit
// picture.
SplatLayer material_layer(const RelitScene& scene);

}  // namespace vitrine
