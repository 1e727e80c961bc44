#include "stages/export/bake/pbr_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/vec.h"
#include "stages/export/bake/texels.h"

namespace vitrine {

namespace {

constexpr float kDielectricUpTo = kSpecularColorFactor * kDielectricF0, kMetalFrom = 0.6f;  // mean reflectance
constexpr float kLeastMarks = 0.02f;                                                        // anisotropy that shows
constexpr float kTrustedNormal = 0.5f;  // cosine: the normal of a surfel tilted further from the mesh is ignored

uint8_t byte(float v) { return uint8_t(std::lround(255.f * std::clamp(v, 0.f, 1.f))); }
uint8_t srgb_byte(float linear) { return byte(srgb_from_linear(std::clamp(linear, 0.f, 1.f))); }

Vec3f blended(std::span<const Vec3f> at, const std::array<uint32_t, 3>& v, const Vec3f& b) {
  return b.x * at[v[0]] + b.y * at[v[1]] + b.z * at[v[2]];
}

SurfelMaterial blended(std::span<const SurfaceSample> at, const std::array<uint32_t, 3>& v, const Vec3f& b) {
  SurfelMaterial out{.roughness = 0};
  for (size_t k = 0; k < 3; ++k) {
    const SurfelMaterial& m = at[v[k]].material;
    out.color += b[k] * m.color;
    out.f0 += b[k] * m.f0;
    out.roughness += b[k] * m.roughness;
    out.transmission += b[k] * m.transmission;
    out.marks += b[k] * m.marks;
  }
  return out;
}

// One vertex per pair (vertex, chart), in order of first use; one part per pair (object, class).
void split_vertices(const TriMesh& mesh, const Atlas& atlas, std::span<const SurfaceSample> at_vertex, const SolidGlass* solid,
                    PbrMesh& out) {
  // The copies of a mesh vertex form a linked list through `next`.
  std::vector<uint32_t> first(mesh.positions.size(), kNoFace), next, chart_of;
  std::map<std::pair<uint16_t, FaceClass>, std::vector<std::array<uint32_t, 3>>> parts;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const uint32_t chart = atlas.chart_of_face[f];
    std::array<uint32_t, 3> face{};
    float transmission = 0;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = mesh.faces[f][k];
      transmission += at_vertex[v].material.transmission / 3;
      uint32_t found = first[v];
      while (found != kNoFace && chart_of[found] != chart) found = next[found];
      if (found == kNoFace) {
        found = uint32_t(out.positions.size());
        const Vec3f& n = mesh.normals[v];
        const AtlasChart& c = atlas.charts[chart];
        Vec3f t = c.u - dot(n, c.u) * n;
        if (!(squared_length(t) > 1e-8f)) t = orthonormal_basis(n).u;
        const Vec2f texel = atlas.texel(chart, mesh.positions[v]);
        out.positions.push_back(mesh.positions[v]);
        out.normals.push_back(n);
        out.tangents.push_back(normalized(t));
        out.uv.push_back({texel.x / float(atlas.size), texel.y / float(atlas.size)});
        out.source_vertex.push_back(v);
        next.push_back(first[v]);
        chart_of.push_back(chart);
        first[v] = found;
      }
      face[k] = found;
    }
    const FaceClass as = !(transmission > kGlassTransmission)  ? FaceClass::Opaque
                         : solid != nullptr && solid->faces[f] ? FaceClass::SolidGlass
                                                               : FaceClass::Pane;
    parts[{mesh.object_of_face(f), as}].push_back(face);
  }
  for (auto& [key, faces] : parts) out.parts.push_back({key.first, key.second, std::move(faces)});
}

// Texel of KHR_materials_anisotropy for marks in the frame of `normal` and `tangent` (zero: unknown).
void bake_marks(const Vec3f& marks, const Vec3f& normal, const Vec3f& tangent, int x, int y, Image8& texture) {
  const Vec3f across = cross(normal, marks);
  const bool brushed = length(across) > kLeastMarks && tangent != Vec3f{};
  const Vec3f unit = brushed ? normalized(across) : tangent;
  const Vec3f values{0.5f * dot(unit, tangent) + 0.5f, 0.5f * dot(unit, cross(normal, tangent)) + 0.5f,
                     brushed ? length(marks) : 0};
  for (int c = 0; c < 3; ++c) texture.at(x, y, c) = byte(values[size_t(c)]);
}

void bake(const TriMesh& mesh, const Atlas& atlas, const SurfaceSampler& sampler, std::span<const SurfaceSample> at_vertex,
          const PbrDesc& desc, PbrMesh& out) {
  const int size = atlas.size;
  PbrTextures& t = out.textures;
  t.base_color = Image8(size, size, 3);
  t.metallic_roughness = Image8(size, size, 3);
  t.normal = Image8(size, size, 3);
  t.specular_color = Image8(size, size, 3);
  t.transmission = Image8(size, size, 1);
  out.any_brushed = std::ranges::any_of(at_vertex, [](const auto& s) { return length(s.material.marks) > kLeastMarks; });
  if (out.any_brushed) t.anisotropy = Image8(size, size, 3);
  const bool solid = out.has(FaceClass::SolidGlass);
  std::vector<uint8_t> thick;  // texels of solid glass
  if (solid) {
    t.thickness = Image8(size, size, 1);
    thick.resize(size_t(size) * size_t(size));
  }
  const std::vector<AtlasTexel> texels = covered_texels(atlas, mesh);
  std::vector<Vec3f> points(texels.size()), normals(texels.size());
  std::vector<uint8_t> behind(texels.size());
  for (size_t i = 0; i < texels.size(); ++i) {
    const auto& v = mesh.faces[texels[i].face];
    behind[i] = sampler.is_behind(v[0]);
    points[i] = blended(mesh.positions, v, texels[i].barycentric);
    const Vec3f n = blended(mesh.normals, v, texels[i].barycentric);
    const float l = length(n);
    normals[i] = l > 1e-6f ? n / l : mesh.normals[v[0]];
  }
  const std::vector<SurfaceSample> samples = sampler.samples(points, normals, desc.reach, behind);
  std::vector<uint8_t> known(size_t(size) * size_t(size), 0);
  size_t met = 0;
  for (size_t i = 0; i < texels.size(); ++i) {
    const AtlasTexel& texel = texels[i];
    const int x = int(texel.x), y = int(texel.y);
    const bool hit = samples[i].weight > 0;
    met += hit;
    const SurfelMaterial m = hit ? samples[i].material : blended(at_vertex, mesh.faces[texel.face], texel.barycentric);
    const PbrValues p = pbr_values(m);
    known[size_t(y) * size_t(size) + size_t(x)] = 1;
    for (int c = 0; c < 3; ++c) {
      t.base_color.at(x, y, c) = srgb_byte(p.base_color[size_t(c)]);
      t.specular_color.at(x, y, c) = srgb_byte(p.specular_color[size_t(c)]);
    }
    t.metallic_roughness.at(x, y, 0) = 255;
    t.metallic_roughness.at(x, y, 1) = byte(p.roughness);
    t.metallic_roughness.at(x, y, 2) = byte(p.metallic);
    t.transmission.at(x, y) = byte(p.transmission);
    // Normal in the tangent frame of the texel: tangent = the chart's u, orthogonalised to the normal.
    const AtlasChart& chart = atlas.charts[atlas.chart_of_face[texel.face]];
    const Vec3f& n = normals[i];
    Vec3f local{0, 0, 1};
    const Vec3f tangent = chart.u - dot(n, chart.u) * n;
    // Solid glass refracts at its smooth wall (find_solid_glass), so its surfel normals are ignored.
    const bool on_shell = solid && desc.solid->faces[texel.face];
    const Vec3f unit = squared_length(tangent) > 1e-4f ? normalized(tangent) : Vec3f{};
    if (out.any_brushed) bake_marks(m.marks, n, unit, x, y, t.anisotropy);
    if (!on_shell && dot(samples[i].normal, n) > kTrustedNormal && unit != Vec3f{}) {
      local = {dot(samples[i].normal, unit), dot(samples[i].normal, cross(n, unit)), dot(samples[i].normal, n)};
    }
    if (on_shell) {
      const auto& v = mesh.faces[texel.face];
      float thickness = 0;
      for (size_t k = 0; k < 3; ++k) thickness += texel.barycentric[k] * desc.solid->thickness[v[k]];
      t.thickness.at(x, y) = byte(thickness / out.thickness);
      thick[size_t(y) * size_t(size) + size_t(x)] = 1;
    }
    for (size_t c = 0; c < 3; ++c) t.normal.at(x, y, int(c)) = byte(0.5f * local[c] + 0.5f);
    for (size_t c = 0; c < 3; ++c) out.any_specular |= std::abs(p.specular_color[c] * kSpecularColorFactor - 1) > 0.02f;
  }
  out.covered = texels.empty() ? 0 : double(met) / double(texels.size());
  for (Image8* image : {&t.base_color, &t.metallic_roughness, &t.normal, &t.specular_color, &t.transmission})
    fill_gaps(*image, known);
  if (out.any_brushed) fill_gaps(t.anisotropy, known);
  if (solid) fill_gaps(t.thickness, thick);
}

}  // namespace

PbrValues pbr_values(const SurfelMaterial& m) {
  PbrValues out;
  const float mean = (m.f0.x + m.f0.y + m.f0.z) / 3;
  out.metallic = std::clamp((mean - kDielectricUpTo) / (kMetalFrom - kDielectricUpTo), 0.f, 1.f);
  out.transmission = std::clamp(m.transmission, 0.f, 1.f) * (1 - out.metallic);
  out.roughness = std::clamp(m.roughness, 0.f, 1.f) * (1 - out.transmission);
  for (size_t c = 0; c < 3; ++c) {
    const float below = (1 - out.transmission) * std::clamp(m.color[c], 0.f, 1.f) + out.transmission;
    out.base_color[c] = (1 - out.metallic) * below + out.metallic * std::clamp(m.f0[c], 0.f, 1.f);
    out.specular_color[c] = std::clamp(m.f0[c] / kDielectricUpTo, 0.f, 1.f);
  }
  return out;
}

PbrMesh make_pbr_mesh(const TriMesh& mesh, const SurfaceSampler& sampler, std::span<const SurfaceSample> at_vertex,
                      const PbrDesc& desc) {
  VITRINE_CHECK(mesh.normals.size() == mesh.positions.size(), "the mesh needs vertex normals");
  VITRINE_CHECK(at_vertex.size() == mesh.positions.size(), "one sample per vertex");
  PbrMesh out;
  const Atlas atlas = make_atlas(mesh, desc.texture_size);
  split_vertices(mesh, atlas, at_vertex, desc.solid, out);
  out.charts = atlas.charts.size();
  if (out.has(FaceClass::SolidGlass)) out.ior = desc.solid->ior, out.thickness = desc.solid->greatest;
  bake(mesh, atlas, sampler, at_vertex, desc, out);
  return out;
}

}  // namespace vitrine
