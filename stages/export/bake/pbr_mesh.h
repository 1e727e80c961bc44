// Mesh with PBR textures for export: vertices split at chart borders, texture coordinates, tangents, faces grouped by object and
// class (opaque, glass panes, solid glass), and textures of glTF's metallic-roughness model, baked from the surfels.
//
// Conversion of our layers (core/render/model/kernels/layer_blend.h) to glTF. At normal incidence a surface reflects
//   R = k_s + (1 - k_s) g(k_s) f0,
// and at any angle R + (1 - R)(1 - cos)^5: a Schlick term with f0 = R over the base, as in glTF's dielectric.
//   metalness m     0 where the mean of R <= 0.2, 1 where it is >= 0.6, linear between
//   base colour     (1 - m) c + m R,  c = albedo (or trained colour), blended to white by the transmission: glass is untinted
//   specular colour R / 0.2 with the factor 5 (5 x 0.04 = 0.2): the dielectric's f0 up to 0.2
//   transmission    light that passes below the reflection: tau, with the blend rtrgs k_s tau
//   anisotropy      strength = length of the marks; glTF stretches roughness across them (microfacet.h)
//   roughness       r (1 - tau): glTF blurs transmission through rough glass, our transmitted rays are not blurred
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/render/model/thick_glass.h"
#include "core/scene/image/image.h"
#include "stages/export/bake/atlas.h"
#include "stages/export/bake/surface_material.h"

namespace vitrine {

// Solid glass in an exported mesh (core/render/model/thick_glass.h) and its thickness. Its faces are those on the glass walls
// that refract rays; their vertices get the smooth normals of these walls, because refraction shows voxel steps. `thickness` is
// defined by glTF's KHR_materials_volume: distance along the inward normal to the other side.

struct SolidGlass {
  float ior = 1.5f;
  std::vector<uint8_t> faces;    // [f] 1: on a glass wall
  std::vector<float> thickness;  // [v] scene units; 0 outside solid glass
  float greatest = 0;            // maximum thickness
};

// Replaces normals of `mesh`, which must have them.
SolidGlass find_solid_glass(TriMesh& mesh, const ThickGlass& glass);

// Faces of `content`, the mesh behind glass, that are outside the glass itself.
std::vector<uint8_t> outside_of(const ThickGlass& glass, const TriMesh& content);

constexpr float kDielectricF0 = 0.04f;      // of ior 1.5
constexpr float kSpecularColorFactor = 5;   // f0 = specular colour texture x this x kDielectricF0
constexpr float kGlassTransmission = 0.3f;  // faces with more transmission are glass

struct PbrTextures {
  Image8 base_color;          // sRGB
  Image8 metallic_roughness;  // R unused (255), G roughness, B metalness
  Image8 normal;              // tangent space, +X right, +Y up in the texture, (n + 1) / 2
  Image8 specular_color;      // sRGB
  Image8 transmission;        // grey
  Image8 anisotropy;  // direction across the marks in tangent space as (t + 1) / 2, B strength; empty where nothing is brushed
  Image8 thickness;   // grey, 255 = PbrMesh::thickness; empty without solid glass
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
  std::vector<uint32_t> source_vertex;  // of the source mesh
  std::vector<PbrPart> parts;           // by object, then by class; none is empty
  PbrTextures textures;
  bool any_specular = false;  // some f0 differs from that of plain dielectrics
  bool any_brushed = false;   // metal with marks (textures.anisotropy)
  double covered = 0;         // share of the surface texels that meet surfels
  size_t charts = 0;
  float ior = 1.5f, thickness = 0;  // of solid glass; maximum thickness, scene units

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
  int texture_size = 0;               // 0: from the mesh (make_atlas)
  float reach = 0;                    // largest distance of used surfels from the mesh
  const SolidGlass* solid = nullptr;  // of the same mesh; nullptr: all glass is thin
};

// `at_vertex`: sample_vertices() of the same mesh, for texels without surfels and for the class of a face.
PbrMesh make_pbr_mesh(const TriMesh& mesh, const SurfaceSampler& sampler, std::span<const SurfaceSample> at_vertex,
                      const PbrDesc& desc);

// glTF parameters of a material.
struct PbrValues {
  Vec3f base_color{};      // linear
  Vec3f specular_color{};  // linear, before the factor
  float metallic = 0, roughness = 1, transmission = 0;
};
PbrValues pbr_values(const SurfelMaterial& material);

}  // namespace vitrine
