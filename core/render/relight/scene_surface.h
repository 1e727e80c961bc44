// The mesh of a scene for light transport: occluders, panes of glass, reflectance per vertex. Vertices sample their materials
// from the surfels along a short ray.
#pragma once

#include <algorithm>
#include <vector>

#include "core/render/relight/relit_scene.h"
#include "core/render/relight/subsurface.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

// A position on the mesh: face and barycentric weights.
struct SurfacePlace {
  uint32_t face = 0;
  Vec3f weights{};
};

class SceneSurface {
 public:
  explicit SceneSurface(const RelitScene& scene);

  // With normals; vertices and faces of the surroundings follow those of the scene's mesh.
  const TriMesh& mesh() const { return mesh_; }
  bool surrounding(uint32_t face) const { return face >= near_faces_; }
  const std::vector<Vec3f>& reflectance() const { return reflectance_; }  // [v]
  const SubsurfaceFilter& subsurface() const { return subsurface_; }
  // [v] direction of the marks of brushed metal, times its anisotropy. Empty: no metal is brushed.
  const std::vector<Vec3f>& marks() const { return marks_; }
  // Mean edge length of the mesh: the unit of the distance between surfels and mesh, and of ray offsets.
  float grain() const { return grain_; }

  std::optional<MeshHit> first_hit(const Vec3f& origin, const Vec3f& direction, float near = 0) const {
    return hits_.first_hit(origin, direction, near);
  }
  // The first hit behind all panes.
  std::optional<MeshHit> first_solid_hit(const Vec3f& origin, const Vec3f& direction) const;
  // True if nothing, not even a pane, lies between the points.
  bool free_between(const Vec3f& a, const Vec3f& b) const { return !hits_.occluded(a, b - a, 0, 1); }
  // The position where a ray hits the front of the mesh before `far`.
  std::optional<SurfacePlace> front_near(const Vec3f& origin, const Vec3f& direction, float far) const {
    const auto hit = hits_.first_face(origin, direction, 0, far);
    if (!hit || hit->from_inside) return std::nullopt;
    return place(*hit);
  }
  // Transmittance of a segment: 0 behind solid surfaces, below 1 behind glass.
  float visibility(const Vec3f& origin, const Vec3f& direction, float far = MeshHits::kFar) const;

  // A hit of a ray: a solid surface or a pane, with its share of the ray.
  struct Meeting {
    SurfacePlace place;
    float share = 0;
    bool front = true;
  };
  // Calls meet(Meeting) for each hit; returns the share that leaves the scene.
  template <class Meet>
  float follow(const Vec3f& origin, const Vec3f& direction, const Meet& meet) const {
    float near = 0, share = 1;
    for (int panes = 0; panes < MeshHits::kMostPanes; ++panes) {
      const auto hit = hits_.first_face(origin, direction, near);
      if (!hit) return share;
      const float through = face_transmittance(hit->face);
      meet(Meeting{place(*hit), share * (1 - through), !hit->from_inside});
      share *= through;
      if (share < kLeastShare) return 0;
      near = next_near(hit->t);
    }
    return 0;
  }
  // Interpolated from the vertices, outward; the face normal where they cancel.
  Vec3f smooth_normal(const MeshHit& hit) const {
    const Vec3f n = at(mesh_.normals, place(hit));
    return squared_length(n) > 0 ? normalized(n) : hit.normal;
  }
  Vec3f at(const std::vector<Vec3f>& per_vertex, const SurfacePlace& place) const {
    const auto& f = mesh_.faces[place.face];
    return place.weights.x * per_vertex[f[0]] + place.weights.y * per_vertex[f[1]] + place.weights.z * per_vertex[f[2]];
  }

 private:
  static constexpr float kLeastShare = 0.01f;
  static constexpr float kSamePlace = 1e-3f;  // in grains: faces closer along a ray are one surface

  float face_transmittance(uint32_t face) const { return glass_ ? transmittance_[face] : 0.f; }
  float next_near(float t) const { return t * (1 + 4e-6f) + kSamePlace * grain_; }
  static SurfacePlace place(const FaceHit& hit) {
    const float u = std::clamp(hit.u, 0.f, 1.f), v = std::clamp(hit.v, 0.f, 1 - u);
    return {hit.face, {1 - u - v, u, v}};
  }
  void take_materials(const RelitScene& scene);

  size_t near_vertices_ = 0, near_faces_ = 0;
  float grain_ = 0;
  TriMesh mesh_;
  MeshHits hits_;
  bool glass_ = false;
  std::vector<Vec3f> reflectance_;    // [v]
  std::vector<float> transmittance_;  // [f]
  SubsurfaceFilter subsurface_;
  std::vector<Vec3f> marks_;
};

}  // namespace vitrine
