// Ray casting against a triangle mesh: occlusion, and the hits that split a transmitted ray into an interior and an exterior
// segment (algorithms 5.2). Two-sided. Faces are counter-clockwise seen from outside: a hit from inside has dot(normal,
// direction) > 0.
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
  // Copies the geometry. Throws Error{Input} if a face refers to a missing vertex.
  explicit MeshHits(const TriMesh& mesh);
  ~MeshHits();
  MeshHits(const MeshHits&) = delete;
  MeshHits& operator=(const MeshHits&) = delete;

  // Nearest hit with near < t < far. first_face() does not compute the normal.
  std::optional<FaceHit> first_face(const Vec3f& origin, const Vec3f& direction, float near = 0.f, float far = kFar) const;
  std::optional<MeshHit> first_hit(const Vec3f& origin, const Vec3f& direction, float near = 0.f, float far = kFar) const;
  // Exit point of a ray that is inside a glass wall at `near`. Nested walls (glass in glass) are skipped: front faces and back
  // faces are counted until they balance. If the mesh has holes and the count never balances, returns the last back face.
  std::optional<MeshHit> back_surface(const Vec3f& origin, const Vec3f& direction, float near, float far = kFar) const;
  // True if there is a hit between near and far.
  bool occluded(const Vec3f& origin, const Vec3f& direction, float near, float far) const;
  // Product of the transmittances of all hits between 0 and far. Hits are visited in any order, so an opaque face ends the
  // search early. Hits closer to each other than `same` count as one surface (shared edges).
  struct Panes {
    std::span<const float> transmittance;  // one per face; 0 = opaque
    float least = 0;                       // smaller products are treated as 0
    float same = 0;
  };
  static constexpr int kMostPanes = 12;  // with more hits the result is 0
  float transmittance(const Vec3f& origin, const Vec3f& direction, float far, const Panes& panes) const;

  static constexpr float kFar = 1e30f;

 private:
  RTCRayHit nearest(const Vec3f& origin, const Vec3f& direction, float near, float far) const;
  struct Tree;
  std::unique_ptr<Tree> tree_;
  size_t faces_ = 0;
};

}  // namespace vitrine
