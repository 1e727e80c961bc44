// Export format mesh-usd: the mesh as USD text with UsdPreviewSurface materials and the baked textures. One UsdGeomMesh per
// object and one for faces without object, with a subset per face class. UsdPreviewSurface has no transmission: glass has opacity
// 1 - tau, which blends without tint. Particle fields (Gaussians) are not written; use ply-3dgs or gaussians-glb.
#include <algorithm>
#include <set>

#include "core/foundation/base/file.h"
#include "core/scene/image/ldr.h"
#include "stages/export/formats/source.h"

namespace vitrine {
namespace {

struct Texture {
  std::string_view name, file, color_space, type, output, scale_bias;
};

std::string texture_shader(const Texture& t) {
  return fmt::format(R"(      def Shader "{}"
      {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @textures/usd/{}@
        token inputs:sourceColorSpace = "{}"
        token inputs:wrapS = "clamp"
        token inputs:wrapT = "clamp"
        float2 inputs:st.connect = </scene/materials/{{0}}/st.outputs:result>
{}        {} outputs:{}
      }}
)",
                     t.name, t.file, t.color_space, t.scale_bias, t.type, t.output);
}

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
  return text;
}

std::string usd_material(FaceClass kind, float ior) {
  const bool glass = kind != FaceClass::Opaque;
  std::string out = R"(    def Material "{0}"
    {
      token outputs:surface.connect = </scene/materials/{0}/surface.outputs:surface>
      def Shader "surface"
      {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </scene/materials/{0}/base_color.outputs:rgb>
        float inputs:roughness.connect = </scene/materials/{0}/metallic_roughness.outputs:g>
        float inputs:metallic.connect = </scene/materials/{0}/metallic_roughness.outputs:b>
        normal3f inputs:normal.connect = </scene/materials/{0}/normal.outputs:rgb>
        float inputs:ior = {1}
)";
  if (glass) out += "        float inputs:opacity.connect = </scene/materials/{0}/transmission.outputs:r>\n";
  out += R"(        token outputs:surface
      }
      def Shader "st"
      {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
        float2 outputs:result
      }
)";
  out += texture_shader({"base_color", "base_color.png", "sRGB", "float3", "rgb", ""});
  const std::string metallic_roughness =
      texture_shader({"metallic_roughness", "metallic_roughness.png", "raw", "float", "g", ""});
  out += replaced(metallic_roughness, "float outputs:g\n", "float outputs:g\n        float outputs:b\n");
  out += texture_shader({"normal", "normal.png", "raw", "float3", "rgb",
                         "        float4 inputs:scale = (2, 2, 2, 1)\n        float4 inputs:bias = (-1, -1, -1, 0)\n"});
  if (glass)
    out += texture_shader({"transmission", "transmission.png", "raw", "float", "r",
                           "        float4 inputs:scale = (-1, -1, -1, 1)\n        float4 inputs:bias = (1, 1, 1, 0)\n"});
  return replaced(replaced(out, "{0}", name(kind)), "{1}", fmt::format("{}", ior)) + "    }\n";
}

// "[a, b, c]" with line breaks.
template <class Values, class Format>
std::string list(const Values& values, Format&& format) {
  std::string out = "[";
  constexpr size_t kPerLine = 8;
  for (size_t i = 0; i < values.size(); ++i) {
    if (i > 0) out += i % kPerLine == 0 ? ",\n      " : ", ";
    out += format(values[i]);
  }
  return out + "]";
}

// Valid prim name: letters, digits and underscores, no leading digit; other bytes become underscores.
std::string prim_name(std::string text) {
  for (char& c : text)
    if (!(c >= 'a' && c <= 'z') && !(c >= 'A' && c <= 'Z') && !(c >= '0' && c <= '9')) c = '_';
  return text.empty() || (text[0] >= '0' && text[0] <= '9') ? "_" + text : text;
}

std::string usd_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

// Prim with the parts of one object.
std::string usd_mesh(const std::string& prim, const std::string& shown, const PbrMesh& mesh, std::span<const PbrPart> parts,
                     const ExportFrame& frame) {
  std::vector<uint32_t> vertices;
  for (const PbrPart& part : parts)
    for (const auto& face : part.faces) vertices.insert(vertices.end(), face.begin(), face.end());
  std::ranges::sort(vertices);
  vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
  std::vector<std::array<size_t, 3>> faces;
  for (const PbrPart& part : parts)
    for (const auto& face : part.faces)
      for (size_t k = 0; auto& corner : faces.emplace_back())
        corner = size_t(std::ranges::lower_bound(vertices, face[k++]) - vertices.begin());
  const auto point = [&](uint32_t v) {
    const Vec3f p = frame.point(mesh.positions[v]);
    return fmt::format("({}, {}, {})", p.x, p.y, p.z);
  };
  const auto normal = [&](uint32_t v) {
    const Vec3f n = frame.direction(mesh.normals[v]);
    return fmt::format("({:.4f}, {:.4f}, {:.4f})", n.x, n.y, n.z);
  };
  const auto uv = [&](uint32_t v) { return fmt::format("({:.6f}, {:.6f})", mesh.uv[v].x, 1 - mesh.uv[v].y); };
  std::string out = fmt::format("  def Mesh \"{}\"", prim);
  if (shown != prim) out += fmt::format(" (\n    displayName = {}\n  )", usd_string(shown));
  out += "\n  {\n    uniform token subdivisionScheme = \"none\"\n";
  out += fmt::format("    uniform bool doubleSided = {}\n", mesh.has_glass() ? "true" : "false");
  out += "    int[] faceVertexCounts = " + list(faces, [](const auto&) { return "3"; }) + "\n";
  out +=
      "    int[] faceVertexIndices = " + list(faces, [](const auto& f) { return fmt::format("{}, {}, {}", f[0], f[1], f[2]); }) +
      "\n";
  out += "    point3f[] points = " + list(vertices, point) + "\n";
  out += "    normal3f[] normals = " + list(vertices, normal) + " (interpolation = \"vertex\")\n";
  out += "    texCoord2f[] primvars:st = " + list(vertices, uv) + " (interpolation = \"vertex\")\n";
  size_t first = 0;
  for (const PbrPart& part : parts) {
    std::vector<size_t> indices(part.faces.size());
    for (size_t& i : indices) i = first++;
    out += fmt::format("    def GeomSubset \"{}\" (prepend apiSchemas = [\"MaterialBindingAPI\"])\n    {{\n", name(part.kind));
    out += "      uniform token elementType = \"face\"\n      uniform token familyName = \"materialBind\"\n";
    out += "      int[] indices = " + list(indices, [](size_t i) { return std::to_string(i); }) + "\n";
    out += fmt::format("      rel material:binding = </scene/materials/{}>\n    }}\n", name(part.kind));
  }
  return out + "  }\n";
}

std::vector<std::string> write_mesh_usd(ExportSource& source, const std::filesystem::path& folder) {
  const PbrMesh& mesh = source.pbr_mesh();
  // A USD stage has an up axis and is right-handed: a left-handed frame would appear mirrored.
  ExportFrame frame = source.frame();
  if (frame.mirrored()) {
    const ExportAxes axes = frame.y_up() ? ExportAxes::Rhyu : ExportAxes::Rhzu;
    source.add_note(fmt::format("USD is right-handed: written in {}", kExportAxesWords[size_t(axes)]));
    frame = source.frame(axes);
  }
  std::string out = fmt::format(R"(#usda 1.0
(
  doc = "vitrine: {}"
  defaultPrim = "scene"
  upAxis = "{}"
  metersPerUnit = 1
)

def Xform "scene"
{{
)",
                                color_note(source), frame.y_up() ? "Y" : "Z");
  std::set<std::string> taken{"materials"};
  for (size_t i = 0, end = 0; i < mesh.parts.size(); i = end) {
    const uint16_t object = mesh.parts[i].object;
    while (end < mesh.parts.size() && mesh.parts[end].object == object) ++end;
    const std::string shown = object == 0 ? "mesh" : source.object_name(object);
    std::string prim = prim_name(shown);
    while (!taken.insert(prim).second) prim += '_';
    out += usd_mesh(prim, shown, mesh, std::span(mesh.parts).subspan(i, end - i), frame);
  }
  out += "  def Scope \"materials\"\n  {\n";
  for (const FaceClass kind : kFaceClasses)
    if (mesh.has(kind)) out += usd_material(kind, kind == FaceClass::SolidGlass ? mesh.ior : 1.5f);
  out += "  }\n}\n";
  write_file(folder / "mesh.usda", out);

  std::vector<std::string> files{"mesh.usda"};
  make_folders(folder / "textures/usd");
  const auto texture = [&](const char* name, const Image8& image) {
    files.push_back(fmt::format("textures/usd/{}.png", name));
    write_ldr(folder / files.back(), image);
  };
  texture("base_color", mesh.textures.base_color);
  texture("metallic_roughness", mesh.textures.metallic_roughness);
  texture("normal", mesh.textures.normal);
  if (mesh.has_glass()) texture("transmission", mesh.textures.transmission);
  return files;
}

}  // namespace

ExportFormat mesh_usd_format() {
  return {.name = "mesh-usd",
          .summary = "the mesh as USD text with UsdPreviewSurface materials",
          .holds =
              "a mesh for each object; triangles, normals, texture coordinates; textures of base colour, metalness and "
              "roughness, normals; glass as "
              "opacity; a subset each for opaque faces, panes and solid glass, which has its index of refraction",
          .loses =
              "transmission as such, refraction, and the colour of reflections (UsdPreviewSurface has none of them), view "
              "dependence, Gaussians",
          .write = write_mesh_usd};
}

}  // namespace vitrine
