// The mesh as other programs want it: vertices split at the borders of charts, texture coordinates, tangents, faces by object and
// class (opaque, panes of glass, solid glass), and the textures of glTF's metallic-roughness model, baked from the surfels.
//
// From our layers (core/render/model/kernels/layer_blend.h) to glTF. At normal incidence a surface of ours reflects
//   R = k_s + (1 - k_s) g(k_s) f0,
// and at any angle R + (1 - R)(1 - cos)^5: a Schlick term with f0 = R over what is below, which is what glTF's dielectric is.
//   metalness m     0 where the mean of R <= 0.2, 1 where it is >= 0.6, a ramp between them
//   base colour     (1 - m) c + m R,  c = albedo (or trained colour), mixed with white by the transmission: glass lets light
//                   through untinted
//   specular colour R / 0.2 with the factor 5 (5 x 0.04 = 0.2): the dielectric's f0 up to 0.2
//   transmission    what passes below the reflection: tau, with the blend rtrgs k_s tau
//   roughness       r (1 - tau): glTF blurs what is seen through rough glass, while our transmitted rays go straight
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/scene/image/image.h"
#include "stages/export/bake/atlas.h"
#include "stages/export/bake/solid_glass.h"
#include "stages/export/bake/surface_material.h"

namespace vitrine {

constexpr float kDielectricF0 = 0.04f;      // of ior 1.5
constexpr float kSpecularColorFactor = 5;   // specular colour texture times this times kDielectricF0 = f0
constexpr float kGlassTransmission = 0.3f;  // faces that let more through than this are glass

struct PbrTextures {
  Image8 base_color;          // sRGB
  Image8 metallic_roughness;  // R unused (255), G roughness, B metalness
  Image8 normal;              // tangent space, +X right, +Y up in the texture, (n + 1) / 2
  Image8 specular_color;      // sRGB
  Image8 transmission;        // grey
  Image8 thickness;           // grey, 255 = PbrMesh::thickness; empty where no glass is solid
};

enum class FaceClass : unsigned char { Opaque, Pane, SolidGlass };
inline constexpr FaceClass kFaceClasses[] = {FaceClass::Opaque, FaceClass::Pane, FaceClass::SolidGlass};
constexpr const char* name(FaceClass c) {
  return c == FaceClass::Opaque ? "opaque" : c == FaceClass::Pane ? "glass" : "solid_glass";
}

struct PbrPart {
  uint16_t object = 0;  // of the table of objects; 0: none
  FaceClass kind = FaceClass::Opaque;
  std::vector<std::array<uint32_t, 3>> faces;
};

struct PbrMesh {
  std::vector<Vec3f> positions, normals;
  std::vector<Vec3f> tangents;          // along +x of the texture; the bitangent, normal x tangent, points up in the texture
  std::vector<Vec2f> uv;                // [0,1], origin at the upper left of the texture
  std::vector<uint32_t> source_vertex;  // of the mesh that it was made of
  std::vector<PbrPart> parts;           // by object, then by class; none is empty
  PbrTextures textures;
  bool any_specular = false;  // some f0 is not that of plain dielectrics
  double covered = 0;         // share of the texels on the surface where surfels were met
  size_t charts = 0;
  float ior = 1.5f, thickness = 0;  // of solid glass; the greatest thickness, scene units

  size_t count(FaceClass c) const {  // of faces
    size_t n = 0;
    for (const PbrPart& part : parts) n += part.kind == c ? part.faces.size() : 0;
    return n;
  }
  bool has(FaceClass c) const { return count(c) > 0; }
  bool has_objects() const { return !parts.empty() && parts.back().object > 0; }
  bool has_glass() const { return has(FaceClass::Pane) || has(FaceClass::SolidGlass); }
};

struct PbrDesc {
  int texture_size = 0;               // 0: by the mesh (make_atlas)
  float reach = 0;                    // how far from the mesh surfels count
  const SolidGlass* solid = nullptr;  // of the same mesh; nullptr: all glass is thin
};

// `at_vertex`: sample_vertices() of the same mesh, for texels that meet no surfel and for the class of a face.
PbrMesh make_pbr_mesh(const TriMesh& mesh, const SurfaceSampler& sampler, std::span<const SurfaceSample> at_vertex,
                      const PbrDesc& desc);

// The glTF parameters of a material.
struct PbrValues {
  Vec3f base_color{};      // linear
  Vec3f specular_color{};  // linear, before the factor
  float metallic = 0, roughness = 1, transmission = 0;
};
PbrValues pbr_values(const SurfelMaterial& material);

}  // namespace vitrine
