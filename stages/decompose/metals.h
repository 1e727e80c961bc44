// Materials of mirrors and coats (core/scene/objects). Training leaves them as they look: a mirror keeps pictures of the old
// surroundings in its diffuse colours, a coat its highlights. Faces and surfels know their object. Of its pixels C and the light
// L of their mirrored rays (the trained scene, the environment beyond):
//   mirror  F0 = sum C / sum L  per channel, over the rays that meet what is matt of the mesh, which the photos know well;
//           nothing is scattered, and it is as rough as the contrast of what it mirrors says (metal_roughness.h)
//   coat    paint under a smooth dielectric:  C = D + F(n.v) L;  D is the mean of C - F L over the darker half of a face's views,
//           for highlights are brighter than any L that is known; mean of C - D is gloss, which is none of the paint's
// Sums and means, for normals of mirrors are never so good that a single ray meets what its pixel shows.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/light/environment.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/render/model/kernels/layer_blend.h"
#include "core/scene/objects/object_labels.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"

namespace vitrine {

struct MetalsDesc {
  const std::filesystem::path& sfm_folder;
  const TrainedScene& scene;
  const TriMesh& mesh;
  const std::vector<View>& views;
  const Environment& environment;  // of the photos: what mirrored rays see beyond all surfels
  const LabelledObjects& objects;  // trusted ones
  int max_side = 320;              // pixels
  float reach = 0.05f;             // scene units: faces this near give a coated surfel its gloss; mirrored rays begin so far out
};

struct Polished {
  uint16_t object = 0;                            // id
  bool metal = false;                             // of role mirror, with known light on it; else a coat
  Vec3f reflectance{};                            // head on
  std::optional<float> roughness = std::nullopt;  // of metal whose mirrored surroundings are known well enough
  size_t pixels = 0;                              // that it was measured on, over all views
};

struct Metals {
  std::vector<Polished> things;
  std::vector<int> of_surfel;  // index, or -1
  std::vector<Vec3f> gloss;    // [surfels] radiance that a coat adds in the mean of the views
};

Metals find_metals(const MetalsDesc& desc);

// Metals lose their paint and take their reflectance; coats lose their gloss and reflect as a smooth dielectric. `radiance`: of
// the surfels, what their albedos were made of.
void polish_materials(const Metals& found, const TrainedScene& scene, const std::vector<Vec3f>& radiance,
                      DecomposedMaterials& materials);

// A specular weight and f0 that reflect so much head on, in the terms of the blend; in `RtrGs` a full weight, which leaves
// nothing to scatter.
void set_reflectance(LayerBlend blend, const Vec3f& reflectance, float& specular_weight, Vec3f& f0);

}  // namespace vitrine
