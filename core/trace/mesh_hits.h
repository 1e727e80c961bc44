// Rays against a triangle mesh: the surfaces that cut a transmitted ray into an interior and an exterior segment, and visibility
// (algorithms 5.2). Two-sided; faces are counter-clockwise seen from outside, so a hit from inside has dot(normal, direction) >
// 0.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/mesh/tri_mesh.h"

namespace vitrine {

struct MeshHit {
  float t = 0;
  Vec3f normal{};  // geometric, unit, outwards
  uint32_t face = 0;
  bool from_inside = false;
};

class MeshHits {
 public:
  // Keeps a copy of what it needs. Throws Error{Input} when a face names a vertex that does not exist.
  explicit MeshHits(const TriMesh& mesh);
  ~MeshHits();
  MeshHits(const MeshHits&) = delete;
  MeshHits& operator=(const MeshHits&) = delete;

  // The nearest surface with near < t < far.
  std::optional<MeshHit> first_hit(const Vec3f& origin, const Vec3f& direction, float near = 0.f, float far = kFar) const;
  // Where a ray that is inside a shell at `near` leaves it. Shells in the shell (glass in glass) are passed: fronts and backs
  // are counted until as many close as were opened. Where the mesh has holes and the count never closes: the last back.
  std::optional<MeshHit> back_surface(const Vec3f& origin, const Vec3f& direction, float near, float far = kFar) const;
  // Whether anything lies between near and far.
  bool occluded(const Vec3f& origin, const Vec3f& direction, float near, float far) const;

  static constexpr float kFar = 1e30f;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace vitrine
