#include "core/render/relight/scene_surface.h"

#include <algorithm>
#include <cmath>

#include "core/render/trace/tracer.h"
#include "core/scene/mesh/mesh_topology.h"

namespace vitrine {

namespace {

constexpr float kLeastSurfelCoverage = 0.05f;  // minimum coverage by surfels along a vertex's short ray
constexpr float kReach = 3;                    // in grains: search distance for surfels around the mesh
constexpr float kLeastGlass = 0.05f;           // below this transmittance a surface is opaque

TriMesh with_normals(TriMesh mesh) {
  if (mesh.normals.size() != mesh.positions.size()) mesh.normals = vertex_normals(mesh);
  return mesh;
}

TriMesh joined(TriMesh mesh, const TriMesh& more) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
  mesh.normals.insert(mesh.normals.end(), more.normals.begin(), more.normals.end());
  for (const auto& f : more.faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  return mesh;
}

float mean_edge(const TriMesh& mesh) {
  double sum = 0;
  for (const auto& f : mesh.faces)
    for (size_t i = 0; i < 3; ++i) sum += length(mesh.positions[f[(i + 1) % 3]] - mesh.positions[f[i]]);
  return static_cast<float>(sum / (3.0 * static_cast<double>(std::max<size_t>(mesh.faces.size(), 1))));
}

// Mean colour of a layer around each vertex; `rest` where there are no surfels.
std::vector<Vec3f> colors_at_vertices(const SplatLayer& layer, const TriMesh& mesh, float reach, const Vec3f& rest) {
  std::vector<Vec3f> origins(mesh.positions.size()), directions(mesh.positions.size());
  for (size_t v = 0; v < origins.size(); ++v) {
    directions[v] = -mesh.normals[v];
    origins[v] = mesh.positions[v] + reach * mesh.normals[v];
  }
  const std::vector<float> far(origins.size(), 2 * reach);
  const auto tracer = make_tracer();
  tracer->build(layer);
  RayValues values;
  tracer->forward({.origins = origins, .directions = directions, .far = far}, {.sh_degree = 0}, values, nullptr);
  for (size_t v = 0; v < origins.size(); ++v) {
    const float coverage = 1 - values.transmittance[v];
    values.color[v] = coverage > kLeastSurfelCoverage ? values.color[v] / coverage : rest;
  }
  return std::move(values.color);
}

}  // namespace

SceneSurface::SceneSurface(const RelitScene& scene)
    : near_vertices_(scene.mesh.positions.size()),
      near_faces_(scene.mesh.faces.size()),
      grain_(mean_edge(scene.mesh)),
      mesh_(joined(with_normals(scene.mesh), with_normals(scene.surroundings))),
      hits_(mesh_) {
  take_materials(scene);
}

void SceneSurface::take_materials(const RelitScene& scene) {
  const size_t n = scene.materials.size();
  std::vector<Vec3f> reflectance(n), through(n);
  Vec3d mean{};
  for (size_t i = 0; i < n; ++i) {
    const RelitMaterial m = scene.material(i);
    const float t = straight_transmittance(scene.blend(), m);
    reflectance[i] = bounce_reflectance(scene.blend(), m);
    through[i] = {t, t, t};
    mean += cast<double>(reflectance[i]) / double(n);
    glass_ = glass_ || t > kLeastGlass;
  }
  const SplatLayer& surfels = scene.trained.surfels.diffuse;
  reflectance_ = colors_at_vertices(painted_layer(surfels, reflectance), mesh_, kReach * grain_, cast<float>(mean));
  std::ranges::copy(scene.surroundings.colors, reflectance_.begin() + static_cast<std::ptrdiff_t>(near_vertices_));
  // Weighted means may leave [0, 1] by rounding.
  for (Vec3f& r : reflectance_)
    for (size_t c = 0; c < 3; ++c) r[c] = std::clamp(r[c], 0.f, 1.f);
  if (!scene.materials.scatter.empty())
    subsurface_ =
        SubsurfaceFilter(mesh_, colors_at_vertices(painted_layer(surfels, scene.materials.scatter), mesh_, kReach * grain_, {}),
                         reflectance_, grain_);
  if (!scene.materials.marks.empty()) {
    std::vector<Vec3f> colors = scene.materials.marks;
    const Vec3f middle{0.5f, 0.5f, 0.5f};
    for (Vec3f& c : colors) c = middle + 0.5f * c;  // colours are not negative
    marks_ = colors_at_vertices(painted_layer(surfels, colors), mesh_, kReach * grain_, middle);
    for (Vec3f& m : marks_) m = 2.f * (m - middle);
  }
  if (!glass_) return;
  const std::vector<Vec3f> at_vertices = colors_at_vertices(painted_layer(surfels, through), mesh_, kReach * grain_, {});
  transmittance_.resize(mesh_.faces.size());
  for (size_t f = 0; f < near_faces_; ++f) {
    float t = 0;
    for (const uint32_t v : mesh_.faces[f]) t += at_vertices[v].x / 3;
    transmittance_[f] = t > kLeastGlass ? std::min(t, 1.f) : 0.f;
  }
}

std::optional<MeshHit> SceneSurface::first_solid_hit(const Vec3f& origin, const Vec3f& direction) const {
  float near = 0;
  for (int panes = 0; panes <= MeshHits::kMostPanes; ++panes) {
    auto hit = hits_.first_hit(origin, direction, near);
    if (!hit || !(face_transmittance(hit->face) > 0)) return hit;
    near = next_near(hit->t);
  }
  return std::nullopt;
}

float SceneSurface::visibility(const Vec3f& origin, const Vec3f& direction, float far) const {
  if (!glass_) return hits_.occluded(origin, direction, 0, far) ? 0.f : 1.f;
  return hits_.transmittance(origin, direction, far, {transmittance_, kLeastShare, kSamePlace * grain_});
}

}  // namespace vitrine
