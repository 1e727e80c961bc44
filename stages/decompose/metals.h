// Polished things, where the masks mark mirrors that are not glass. Training leaves them as they look: a mirror keeps pictures of
// the old surroundings in its diffuse colours, a glaze its highlights. What they are is told by the photos and the mesh, whose
// shape is that of their silhouettes (stages/mesh). A face is polished when most pixels that show it are marked; connected faces
// are one thing, but those on a known shape are a thing of their own, a metal where its role is a mirror, a glaze where it is a
// coat. Of its pixels C and the light L of their mirrored rays (the trained scene, the environment beyond):
//   metal   shows little from its dim sides: the lower-half mean ratio of the views has less than three quarters of their mean
//   (median face).
//           F0 = sum C / sum L  per channel, over the rays that meet what is dull of the mesh, which the photos know well;
//           nothing is scattered, and it is as rough as the contrast of what it mirrors says (metal_roughness.h). Surfels of a
//           fifth of its brightness that training gave a quarter of its specular weight or less are handles and knobs: they keep
//           their paint
//   glaze   paint under a smooth dielectric:  C = D + F(n.v) L;  D is the mean of C - F L over the lower-half mean ratio of a
//   face's views,
//           for highlights are brighter than any L that is known; mean of C - D is gloss, which is none of the paint's
// Sums and means, for normals of mirrors are never so good that a single ray meets what its pixel shows.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/camera/view.h"
#include "core/light/environment.h"
#include "core/mesh/tri_mesh.h"
#include "core/model/kernels/layer_blend.h"
#include "core/picture/decomposed_materials.h"
#include "core/picture/trained_scene.h"
#include "stages/decompose/mesh_verdicts.h"

namespace vitrine {

struct MetalsDesc {
  const std::filesystem::path& sfm_folder;
  const TrainedScene& scene;
  const TriMesh& mesh;
  const std::vector<View>& views;
  const Environment& environment;  // of the photos: what mirrored rays see beyond all surfels
  // At the given size, above 1/2 on mirrors and metal that are not glass; empty: none there.
  std::function<ImageF(const View&, const Intrinsics&)> mirrors;
  std::function<ImageF(const View&, const Intrinsics&)> glass_or_mirrors;  // likewise
  int max_side = 320;                                                      // pixels
  std::vector<MeshVerdict> verdicts = {};                                  // of the mesh stage, which count where there are some
  float reach = 0.05f;  // scene units: surfels this near to a polished face, and nearest to it, belong to it; mirrored rays begin
                        // so far out
};

struct Polished {
  bool metal = false;    // else a glaze
  float lower_half = 1;  // of the mean over views: that of the lower-half mean ratio of them; the median face
  Vec3f reflectance{};   // head on
  std::optional<float> roughness = std::nullopt;  // of metal whose mirrored surroundings are known well enough
  size_t pixels = 0;                              // that told it, over all views
};

struct Metals {
  std::vector<Polished> things;
  std::vector<int> of_surfel;  // index, or -1
  std::vector<Vec3f> gloss;    // [surfels] radiance that a glaze adds in the mean of the views
};

Metals find_metals(const MetalsDesc& desc);

// Metals lose their paint and take their reflectance; glazes lose their gloss and reflect as a smooth dielectric. `radiance`: of
// the surfels, what their albedos were made of.
void polish_materials(const Metals& found, const TrainedScene& scene, const std::vector<Vec3f>& radiance,
                      DecomposedMaterials& materials);

// A specular weight and f0 that reflect so much head on, in the terms of the blend; in `RtrGs` a full weight, which leaves
// nothing to scatter.
void set_reflectance(LayerBlend blend, const Vec3f& reflectance, float& specular_weight, Vec3f& f0);

}  // namespace vitrine
