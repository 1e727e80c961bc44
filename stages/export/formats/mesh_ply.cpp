// Export format mesh-ply: the cleaned mesh as binary PLY with vertex normals, 8-bit sRGB colours and materials as floats:
//   x y z  nx ny nz  red green blue  f0_r f0_g f0_b  roughness  transmission  [albedo_r albedo_g albedo_b]  [confidence]
//   [object_id]
// f0 is the reflectance at normal incidence including the specular weight (bake/pbr_mesh.h). albedo: linear, if the decompose
// stage ran; the 8-bit colours are then the albedo, else the fused radiance. confidence: 0 to 1, how far training photos agree
// with the surfels (core/render/picture/confidence.h). object_id: ushort, 0: none; the comments contain the names.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/foundation/base/file.h"
#include "core/foundation/math/color.h"
#include "stages/export/formats/source.h"

namespace vitrine {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies numbers as they are");

template <class T>
void put(std::string& out, const T& value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}
void put(std::string& out, const Vec3f& v) {
  for (size_t c = 0; c < 3; ++c) put(out, v[c]);
}

std::vector<std::string> write_mesh_ply(ExportSource& source, const std::filesystem::path& folder) {
  const std::string file = "mesh.ply";
  const TriMesh mesh = in_frame(source.mesh(), source.frame());
  const std::vector<SurfaceSample>& samples = source.vertex_samples();
  const bool albedo = source.has_albedo();

  std::string out = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& line : source.header_lines({"vitrine_format 1", color_note(source)})) out += "comment " + line + "\n";
  out += fmt::format("element vertex {}\n", mesh.positions.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) out += fmt::format("property float {}\n", name);
  for (const char* name : {"red", "green", "blue"}) out += fmt::format("property uchar {}\n", name);
  for (const char* name : {"f0_r", "f0_g", "f0_b", "roughness", "transmission"}) out += fmt::format("property float {}\n", name);
  if (albedo)
    for (const char* name : {"albedo_r", "albedo_g", "albedo_b"}) out += fmt::format("property float {}\n", name);
  const bool confidence = !source.confidence().empty();
  if (confidence) out += "property float confidence\n";
  if (!mesh.object_ids.empty()) out += "property ushort object_id\n";
  out += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.faces.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const SurfelMaterial& m = samples[i].material;
    put(out, mesh.positions[i]);
    put(out, mesh.normals[i]);
    const Vec3f color = albedo || mesh.colors.empty() ? m.color : mesh.colors[i];
    for (size_t c = 0; c < 3; ++c)
      put(out, uint8_t(std::lround(255 * std::clamp(srgb_from_linear(std::clamp(color[c], 0.f, 1.f)), 0.f, 1.f))));
    put(out, m.f0);
    put(out, m.roughness);
    put(out, m.transmission);
    if (albedo) put(out, m.color);
    if (confidence) put(out, samples[i].confidence);
    if (!mesh.object_ids.empty()) put(out, mesh.object_ids[i]);
  }
  for (const auto& f : mesh.faces) {
    put(out, uint8_t(3));
    for (uint32_t v : f) put(out, int32_t(v));
  }
  write_file(folder / file, out);
  return {file};
}

}  // namespace

ExportFormat mesh_ply_format() {
  return {.name = "mesh-ply",
          .summary = "the mesh as binary PLY with materials at the vertices",
          .holds =
              "triangles, vertex normals, vertex colours (8-bit sRGB); reflectance f0, roughness, transmission per vertex, and "
              "the linear albedo when there is one; the confidence of each vertex; the object of each vertex, with their names "
              "in the header",
          .loses = "view dependence, 8-bit colours above 1, detail between vertices, which glass is solid",
          .write = write_mesh_ply};
}

}  // namespace vitrine
