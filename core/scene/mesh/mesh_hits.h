// Rays against a triangle mesh: the surfaces that cut a transmitted ray into an interior and an exterior segment, and visibility
// (algorithms 5.2). Two-sided; faces are counter-clockwise seen from outside, so a hit from inside has dot(normal, direction) >
// 0.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"

struct RTCRayHit;

namespace vitrine {

struct FaceHit {
  float t = 0;
  uint32_t face = 0;
  float u = 0, v = 0;  // weights of the face's second and third corner
  bool from_inside = false;
};
struct MeshHit : FaceHit {
  Vec3f normal{};  // geometric, unit, outwards
};

class MeshHits {
 public:
  // Keeps a copy of what it needs. Throws Error{Input} when a face names a vertex that does not exist.
  explicit MeshHits(const TriMesh& mesh);
  ~MeshHits();
  MeshHits(const MeshHits&) = delete;
  MeshHits& operator=(const MeshHits&) = delete;

  // The nearest surface with near < t < far; first_face() is the same without its normal.
  std::optional<FaceHit> first_face(const Vec3f& origin, const Vec3f& direction, float near = 0.f, float far = kFar) const;
  std::optional<MeshHit> first_hit(const Vec3f& origin, const Vec3f& direction, float near = 0.f, float far = kFar) const;
  // Where a ray that is inside a shell at `near` leaves it. Shells in the shell (glass in glass) are passed: fronts and backs
  // are counted until as many close as were opened. Where the mesh has holes and the count never closes: the last back.
  std::optional<MeshHit> back_surface(const Vec3f& origin, const Vec3f& direction, float near, float far = kFar) const;
  // Whether anything lies between near and far.
  bool occluded(const Vec3f& origin, const Vec3f& direction, float near, float far) const;
  // Product of the transmittances of all surfaces between 0 and far. Faces are met in any order, so that what is solid ends the
  // search early; those nearer to each other than `same` are one surface, as at an edge.
  struct Panes {
    std::span<const float> transmittance;  // one a face; 0 = solid
    float least = 0;                       // a product below counts as 0
    float same = 0;
  };
  static constexpr int kMostPanes = 12;  // more let nothing through
  float transmittance(const Vec3f& origin, const Vec3f& direction, float far, const Panes& panes) const;

  static constexpr float kFar = 1e30f;

 private:
  RTCRayHit nearest(const Vec3f& origin, const Vec3f& direction, float near, float far) const;
  struct Tree;
  std::unique_ptr<Tree> tree_;
  size_t faces_ = 0;
};

}  // namespace vitrine
