// Materials of mirrors and coats (core/scene/objects). Training bakes the surroundings into the diffuse colours of a mirror, and
// highlights into those of a coat. Faces and surfels have an object id. From the object's pixels C and the light L along their
// mirrored rays (the trained scene, and the environment outside it):
//   mirror  F0 = sum C / sum L  per channel, over the rays that meet matt mesh faces, whose radiance the photos determine; no
//           diffuse part; roughness from the contrast of the reflections (below)
//   coat    paint under a smooth dielectric:  C = D + F(n.v) L;  D is the mean of C - F L over the darker half of a face's views,
//           because highlights are brighter than any known L; the mean of C - D is specular light, not part of the paint
// Sums and means, because the normals of mirrors are too inexact for single rays.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/render/model/kernels/layer_blend.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/view.h"
#include "core/scene/light/environment.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine {

struct MetalsDesc {
  const std::filesystem::path& sfm_folder;
  const TrainedScene& scene;
  const TriMesh& mesh;
  const std::vector<View>& views;
  const Environment& environment;  // of the photos: seen by mirrored rays outside all surfels
  const LabelledObjects& objects;  // trusted ones
  int max_side = 320;              // pixels
  float reach = 0.05f;             // scene units: search radius of faces for coats; start offset of mirrored rays
};

struct Reflector {
  uint16_t object = 0;                            // id
  bool metal = false;                             // of role mirror, with known light; else a coat
  Vec3f reflectance{};                            // at normal incidence
  std::optional<float> roughness = std::nullopt;  // of metal with sufficiently known reflections
  size_t pixels = 0;                              // measured pixels, over all views
};

struct Metals {
  std::vector<Reflector> reflectors;
  std::vector<int> of_surfel;  // index, or -1
  std::vector<Vec3f> coat_light;  // [surfels] mean radiance that a coat adds over the views
};

Metals find_metals(const MetalsDesc& desc);

// Metals lose their diffuse colour and get their reflectance; coats lose their specular light and reflect as a smooth dielectric.
// `radiance`: of the surfels, the source of their albedos.
void apply_reflectors(const Metals& found, const TrainedScene& scene, const std::vector<Vec3f>& radiance,
                      DecomposedMaterials& materials);

// Specular weight and f0 with this reflectance at normal incidence, for the blend; in `RtrGs` a full weight, which leaves no
// diffuse part.
void set_reflectance(LayerBlend blend, const Vec3f& reflectance, float& specular_weight, Vec3f& f0);

// Roughness of a metal from the contrast of its reflections. A pixel comparison fails: normals are never exact, so more blur
// always fits better (metal of roughness .22: least error at .33). The difference between neighbouring pixels does not depend on
// exact ray directions and decreases with roughness.

// Pixels of one object that reflect well-known content; [pixel] each.
struct MirroredPixels {
  std::vector<int> view, x, y;
  std::vector<Vec3f> origins, normals, towards_eye;  // on its surface, world, unit
  std::vector<Vec3f> photo;                          // linear radiance
  size_t size() const { return view.size(); }
};

// Radiance that arrives at `origins` from `directions`.
using LightAlong = std::function<std::vector<Vec3f>(std::span<const Vec3f> origins, std::span<const Vec3f> directions)>;

// Roughness (GGX alpha = its square) at which a metal of this reflectance has the contrast of the photos; empty: too few pixels
// with neighbours.
std::optional<float> roughness_of_contrast(const MirroredPixels& pixels, const Vec3f& reflectance, const LightAlong& light);

}  // namespace vitrine
