#include "core/render/model/thick_glass.h"

#include <cmath>
#include <limits>
#include <utility>

#include "core/foundation/base/error.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/render/model/kernels/fresnel.h"
#include "core/render/model/kernels/mirror.h"

namespace vitrine {

namespace {

constexpr float kOffSurface = 2e-5f;  // scene units: ray offset against self-intersection
constexpr float kTolerance_rel = 0.01f, kToleranceVoxels = 3;
constexpr int kSmoothing = 10;  // Taubin passes: they remove voxel steps from the normals of a mesh
constexpr int kMostSurfaces = 32;
constexpr double kSolidEdge_rel = 0.02;  // of a shape's size: edges of its mesh
constexpr Vec3f kProbes[] = {{0.31f, 0.17f, 0.94f},
                             {-0.88f, 0.38f, 0.29f},
                             {0.23f, -0.92f, 0.32f},
                             {0.64f, 0.61f, -0.47f},
                             {-0.41f, -0.36f, -0.84f}};  // unit to a percent; not axis-aligned, since mesh edges are

TriMesh with_normals(TriMesh mesh) {
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

}  // namespace

ThickGlass::ThickGlass(TriMesh mesh, float ior, float tolerance)
    : mesh_(with_normals(std::move(mesh))), ior_(ior), tolerance_(tolerance), hits_(mesh_) {
  VITRINE_CHECK(ior > 1, "glass is denser than air");
}

Vec3f ThickGlass::normal_at(uint32_t face, const Vec3f& point) const {
  const auto& f = mesh_.faces[face];
  const Vec3f &a = mesh_.positions[f[0]], &b = mesh_.positions[f[1]], &c = mesh_.positions[f[2]];
  const Vec3f n = cross(b - a, c - a);
  const float u = dot(n, cross(c - b, point - b)), v = dot(n, cross(a - c, point - c)), w = dot(n, cross(b - a, point - a));
  return normalized(u * mesh_.normals[f[0]] + v * mesh_.normals[f[1]] + w * mesh_.normals[f[2]]);
}

BentRay ThickGlass::path(const Vec3f& eye, const Vec3f& direction, float surface) const {
  BentRay ray;
  const auto first = hits_.first_hit(eye, direction);
  if (!first || first->from_inside || std::abs(first->t - surface) > std::max(tolerance_, kTolerance_rel * surface)) return ray;

  const auto ends = [&](GlassPath how) {
    BentRay straight;
    straight.path = how;
    return straight;
  };
  Vec3f origin = eye, d = direction;
  float near = 0;
  int depth = 0;  // number of nested meshes around the ray
  for (int surfaces = 0; surfaces < kMostSurfaces; ++surfaces) {
    const auto hit = hits_.first_hit(origin, d, near);
    if (!hit) {
      if (depth > 0) return ends(GlassPath::NoExit);
      ray.path = GlassPath::Bent;
      return ray;
    }
    near = hit->t + kOffSurface;
    const bool leaves = hit->from_inside;
    // An exit outside all glass is rounding at a grazing exit, or the rim of a hole: no refraction.
    if (leaves && depth == 0) continue;
    if (depth != (leaves ? 1 : 0)) {  // a mesh nested in the glass
      depth += leaves ? -1 : 1;
      continue;
    }
    const Vec3f point = origin + hit->t * d;
    const float side = leaves ? -1.f : 1.f;
    Vec3f n = side * normal_at(hit->face, point);
    if (!(dot(n, d) < 0)) n = side * hit->normal;  // the smooth normal faces away where the mesh does not: a silhouette
    Vec3f bent;
    float passed = 1;
    if (refract(d, n, leaves ? ior_ : 1 / ior_, bent)) {
      depth = leaves ? 0 : 1;
      if (ray.leg_count > 0) passed = 1 - dielectric_reflectance(-dot(n, d), leaves ? ior_ : 1 / ior_);
    } else {
      bent = reflected(-d, n);
    }
    if (ray.leg_count > 0) ray.legs[ray.leg_count - 1].length = hit->t;
    if (ray.leg_count == BentRay::kMostLegs) return ends(depth > 0 ? GlassPath::TotalReflection : GlassPath::NoExit);
    origin = point;
    d = normalized(bent);
    near = kOffSurface;
    ray.legs[ray.leg_count++] = {origin, d, std::numeric_limits<float>::infinity(), passed};
  }
  return ends(GlassPath::NoExit);
}

std::optional<float> ThickGlass::thickness(const Vec3f& place, const Vec3f& outward_normal) const {
  const auto back = hits_.back_surface(place, -outward_normal, kOffSurface);
  return back ? std::optional(back->t) : std::nullopt;
}

bool ThickGlass::contains(const Vec3f& place) const {
  size_t inside = 0;
  for (const Vec3f& d : kProbes) {
    const auto hit = hits_.first_hit(place, d);
    inside += hit && hit->from_inside;
  }
  return 2 * inside > std::size(kProbes);
}

std::shared_ptr<const ThickGlass> solid_glass(const ShapeSet& shapes) {
  TriMesh all;
  float tolerance = 0;
  for (const ShapeSet::Entry& e : shapes.entries) {
    if (e.role != ShapeRole::Solid) continue;
    const TriMesh mesh = tessellated(e.shape, kSolidEdge_rel * size_of(e.shape));
    const auto first = static_cast<uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    for (const auto& f : mesh.faces) all.faces.push_back({first + f[0], first + f[1], first + f[2]});
    tolerance = std::max(tolerance, static_cast<float>(e.tolerance));
  }
  if (all.faces.empty()) return nullptr;
  return std::make_shared<const ThickGlass>(std::move(all), static_cast<float>(kGlassIndex), tolerance);
}

std::shared_ptr<const ThickGlass> thick_glass(const GlassMesh& mesh, std::span<const uint8_t> chosen, float ior) {
  std::vector<uint8_t> keep(mesh.glass.faces.size());
  bool any = false;
  for (size_t f = 0; f < keep.size(); ++f) any |= (keep[f] = chosen[mesh.region[f]]) != 0;
  if (!any) return nullptr;
  TriMesh part = submesh(mesh.glass, keep);
  taubin_smooth(part, {.iterations = kSmoothing});
  return std::make_shared<const ThickGlass>(std::move(part), ior, kToleranceVoxels * mesh.voxel);
}

}  // namespace vitrine
