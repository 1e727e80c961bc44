// Export format mesh-glb: the mesh as binary glTF 2.0 with textures baked from the surfels (material conversion:
// bake/pbr_mesh.h). The node "scene" contains faces without object, and a child node per object; a mesh has one primitive per
// face class: "opaque", "glass" and "solid_glass". Glass is KHR_materials_transmission, the thin-walled case without refraction,
// as in our panes; double-sided, because a pane of the mesh may be a single surface. Solid glass of the refine stage also has
// KHR_materials_volume, which refracts by the index of refraction; its thickness is in mesh space, like the positions, and
// absorption is omitted, because it was not measured. The file is always +Y up, as glTF requires. Geometry is quantised
// (compact_mesh.h): the node "scene" has the offset and the scale of the mesh. The attribute _CONFIDENCE (16 bits, normalised) is
// the confidence of each vertex (core/render/picture/confidence.h), if it could be measured.
#include "core/scene/image/ldr.h"
#include "stages/export/formats/compact_mesh.h"
#include "stages/export/formats/glb_file.h"
#include "stages/export/formats/source.h"

#include <algorithm>
#include <cmath>

namespace vitrine {
namespace {

using Json = GlbFile::Json;

// Shortest text that gives the same float, instead of seventeen digits of a double.
double shortest(float value) { return std::stod(fmt::format("{}", value)); }

struct TextureIndices {
  int base_color, metallic_roughness, normal, specular_color, transmission, thickness, anisotropy;
};

// `scale`: mesh space units per scene unit.
Json material(GlbFile& glb, const PbrMesh& mesh, const TextureIndices& texture, FaceClass kind, double scale) {
  const auto use = [](int index) { return Json{{"index", index}}; };
  const bool solid = kind == FaceClass::SolidGlass;
  const double ior = solid ? shortest(mesh.ior) : 1.5;
  Json m = {{"name", name(kind)},
            {"pbrMetallicRoughness",
             {{"baseColorTexture", use(texture.base_color)}, {"metallicRoughnessTexture", use(texture.metallic_roughness)}}},
            {"normalTexture", use(texture.normal)}};
  Json& extensions = m["extensions"];
  if (mesh.any_specular) {
    glb.use_extension("KHR_materials_specular");
    extensions["KHR_materials_specular"] = {{"specularColorFactor", Json::array()},
                                            {"specularColorTexture", use(texture.specular_color)}};
    // The texture assumes ior 1.5; glTF multiplies it with the f0 of the ior.
    const double f0 = std::pow((ior - 1) / (ior + 1), 2),
                 factor = solid ? kSpecularColorFactor * kDielectricF0 / f0 : kSpecularColorFactor;
    for (int c = 0; c < 3; ++c) extensions["KHR_materials_specular"]["specularColorFactor"].push_back(shortest(float(factor)));
  }
  if (mesh.any_brushed && kind == FaceClass::Opaque) {
    glb.use_extension("KHR_materials_anisotropy");
    extensions["KHR_materials_anisotropy"] = {{"anisotropyStrength", 1.0}, {"anisotropyTexture", use(texture.anisotropy)}};
  }
  glb.use_extension("KHR_materials_ior");
  extensions["KHR_materials_ior"] = {{"ior", ior}};
  if (kind != FaceClass::Opaque) {
    glb.use_extension("KHR_materials_transmission");
    extensions["KHR_materials_transmission"] = {{"transmissionFactor", 1.0}, {"transmissionTexture", use(texture.transmission)}};
    if (!solid) m["doubleSided"] = true;
  }
  if (solid) {
    glb.use_extension("KHR_materials_volume");
    extensions["KHR_materials_volume"] = {{"thicknessFactor", shortest(float(scale * double(mesh.thickness)))},
                                          {"thicknessTexture", use(texture.thickness)}};
  }
  return m;
}

std::vector<std::string> write_mesh_glb(ExportSource& source, const std::filesystem::path& folder) {
  const std::string file = "mesh.glb";
  const PbrMesh& mesh = source.pbr_mesh();
  const ExportFrame frame = source.frame(ExportAxes::Rhyu);
  std::vector<Vec3f> positions, normals, tangents;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    positions.push_back(frame.point(mesh.positions[i]));
    normals.push_back(frame.direction(mesh.normals[i]));
    tangents.push_back(frame.direction(mesh.tangents[i]));
  }
  std::vector<Triangles> parts;
  for (const PbrPart& part : mesh.parts) parts.push_back(part.faces);
  const CompactMesh geometry =
      compact({.positions = positions, .normals = normals, .tangents = tangents, .uv = mesh.uv, .parts = parts});
  GlbFile glb("vitrine");
  glb.json["asset"]["extras"] = {{"base_color", color_note(source)},
                                 {"unit", source.metric() ? "metre" : "the scene's: camera ring of radius 1"}};
  if (source.place()) glb.add_place(*source.place());
  glb.json["scenes"] = {{{"nodes", {0}}}};
  const double side = shortest(geometry.side);
  Json nodes = {{{"name", "scene"}, {"translation", Json::array()}, {"scale", {side, side, side}}}};
  for (size_t c = 0; c < 3; ++c) nodes[0]["translation"].push_back(shortest(geometry.origin[c]));
  glb.require_extension("KHR_mesh_quantization");
  Json attributes = {{"POSITION", glb.add_normalized(geometry.positions, 3, true)},
                     {"NORMAL", glb.add_normalized(geometry.normals, 3)},
                     {"TANGENT", glb.add_normalized(geometry.tangents, 4)},
                     {"TEXCOORD_0", glb.add_normalized(geometry.uv, 2)}};
  if (!source.confidence().empty()) {
    std::vector<uint16_t> confidence;
    for (const uint32_t v : geometry.source) {
      const float c = source.vertex_samples()[mesh.source_vertex[v]].confidence;
      confidence.push_back(uint16_t(std::lround(65535 * std::clamp(c, 0.f, 1.f))));
    }
    attributes["_CONFIDENCE"] = glb.add_normalized(confidence, 1);
  }
  const PbrTextures& t = mesh.textures;
  TextureIndices texture{};
  texture.base_color = glb.add_texture("base_color", png_bytes(t.base_color));
  texture.metallic_roughness = glb.add_texture("metallic_roughness", png_bytes(t.metallic_roughness));
  texture.normal = glb.add_texture("normal", png_bytes(t.normal));
  if (mesh.any_specular) texture.specular_color = glb.add_texture("specular_color", png_bytes(t.specular_color));
  if (mesh.any_brushed) texture.anisotropy = glb.add_texture("anisotropy", png_bytes(t.anisotropy));
  if (mesh.has_glass()) texture.transmission = glb.add_texture("transmission", png_bytes(t.transmission));
  if (mesh.has(FaceClass::SolidGlass)) texture.thickness = glb.add_texture("thickness", png_bytes(t.thickness));
  std::array<size_t, std::size(kFaceClasses)> material_of{};
  for (const FaceClass kind : kFaceClasses) {
    if (!mesh.has(kind)) continue;
    material_of[static_cast<size_t>(kind)] = glb.json["materials"].size();
    glb.json["materials"].push_back(material(glb, mesh, texture, kind, frame.scale / side));
  }
  Json meshes = Json::array();
  for (size_t i = 0; i < mesh.parts.size(); ++i) {
    const auto& [object, kind, faces] = mesh.parts[i];
    if (i == 0 || mesh.parts[i - 1].object != object) {
      const std::string name = source.object_name(object);
      if (object == 0) {
        nodes[0]["mesh"] = meshes.size();
      } else {
        nodes[0]["children"].push_back(nodes.size());
        nodes.push_back({{"name", name}, {"mesh", meshes.size()}});
      }
      meshes.push_back({{"name", name}, {"primitives", Json::array()}});
    }
    meshes.back()["primitives"].push_back({{"attributes", attributes},
                                           {"indices", glb.add_indices(geometry.parts[i], geometry.vertex_count())},
                                           {"material", material_of[static_cast<size_t>(kind)]},
                                           {"mode", 4}});
  }
  glb.json["nodes"] = std::move(nodes);
  glb.json["meshes"] = std::move(meshes);
  glb.write(folder / file);
  return {file};
}

}  // namespace

ExportFormat mesh_glb_format() {
  return {
      .name = "mesh-glb",
      .summary = "the mesh with baked materials as binary glTF 2.0, +Y up",
      .holds =
          "a node for each object; triangles, normals, tangents, texture coordinates; textures for base colour, metalness and "
          "roughness, normals, specular colour and transmission; brushed metal as KHR_materials_anisotropy; glass as "
          "KHR_materials_transmission, double-sided; solid glass "
          "with its thickness (a texture) and index of refraction as KHR_materials_volume and KHR_materials_ior; "
          "the confidence of each vertex as the attribute _CONFIDENCE",
      .loses =
          "view dependence; gloss of what stands behind glass; what solid glass absorbs (it is clear), and its shell where it "
          "stands on something; base colours above 1; without the decompose stage, and of what is seen through glass alone, the "
          "photos' light is part of the base colour",
      .write = write_mesh_glb};
}

}  // namespace vitrine
