#include "stages/export/bake/pbr_mesh.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/median.h"
#include "core/scene/mesh/mesh_distance.h"

namespace vitrine {

namespace {

// The glass wall is this mesh after smoothing, which moved it by less than a voxel, a third of the tolerance.
constexpr float kSmoothed = 1 / 3.f;
constexpr float kSameSide = 0.5f;  // cosine between both normals
constexpr size_t kPlaces = 256;

}  // namespace

SolidGlass find_solid_glass(TriMesh& mesh, const ThickGlass& glass) {
  VITRINE_CHECK(mesh.normals.size() == mesh.positions.size(), "the mesh needs vertex normals");
  const MeshDistance shell(glass.mesh());
  const float reach = kSmoothed * glass.tolerance();
  SolidGlass out{.ior = glass.ior(),
                 .faces = std::vector<uint8_t>(mesh.faces.size()),
                 .thickness = std::vector<float>(mesh.positions.size())};
  parallel_for(mesh.faces.size(), kPlaces, [&](size_t f) {
    const auto& v = mesh.faces[f];
    const Vec3f &a = mesh.positions[v[0]], &b = mesh.positions[v[1]], &c = mesh.positions[v[2]];
    const ClosestPoint place = shell.closest((a + b + c) / 3.f);
    const Vec3f normal = glass.normal_at(place.face, place.position), across = cross(b - a, c - a);
    out.faces[f] = place.distance <= reach && dot(normal, across) > kSameSide * length(across);
  });
  std::vector<uint8_t> on_shell(mesh.positions.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    if (out.faces[f])
      for (const uint32_t v : mesh.faces[f]) on_shell[v] = 1;
  parallel_for(mesh.positions.size(), kPlaces, [&](size_t v) {
    if (!on_shell[v]) return;
    const ClosestPoint place = shell.closest(mesh.positions[v]);
    mesh.normals[v] = glass.normal_at(place.face, place.position);
    out.thickness[v] = glass.thickness(place.position, mesh.normals[v]).value_or(0.f);
  });
  std::vector<float> known;
  for (const float t : out.thickness)
    if (t > 0) known.push_back(t);
  if (known.empty()) return {.ior = glass.ior(), .faces = std::vector<uint8_t>(mesh.faces.size()), .thickness = out.thickness};
  // Holes of the wall (the object's base): use the median thickness.
  const float middle = upper_median(std::move(known));
  for (size_t v = 0; v < on_shell.size(); ++v)
    if (on_shell[v] && !(out.thickness[v] > 0)) out.thickness[v] = middle;
  out.greatest = std::ranges::max(out.thickness);
  return out;
}

std::vector<uint8_t> outside_of(const ThickGlass& glass, const TriMesh& content) {
  std::vector<uint8_t> inside(content.positions.size()), out(content.faces.size());
  parallel_for(inside.size(), kPlaces, [&](size_t v) { inside[v] = glass.contains(content.positions[v]); });
  for (size_t f = 0; f < out.size(); ++f)
    out[f] = std::ranges::none_of(content.faces[f], [&](uint32_t v) { return inside[v] != 0; });
  return out;
}

}  // namespace vitrine
