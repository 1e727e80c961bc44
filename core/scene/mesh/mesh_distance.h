// Distances between surfaces: points spread evenly over a mesh, and the closest point of a mesh to a given point. With these
// two, accuracy = distances from the samples of a result to the truth, completeness = the other way round.
// The structure is a bounding volume hierarchy (median split of the longest side); answers do not depend on threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct SurfaceSamples {
  std::vector<Vec3f> positions;  // [n]
  std::vector<Vec3f> normals;    // [n] unit normals of the faces
  std::vector<uint32_t> faces;   // [n]
};

// n points, uniform by area (systematic along the cumulated area, random inside the triangles). Empty when the area is 0.
SurfaceSamples sample_surface(const TriMesh& mesh, size_t n, uint64_t seed);

struct ClosestPoint {
  Vec3f position{};
  uint32_t face = 0;
  float distance = 0;
};

class MeshDistance {
 public:
  // Copies what it needs: the mesh may go away. Faces of zero area count as the segments or points they are.
  explicit MeshDistance(const TriMesh& mesh);

  bool empty() const { return triangles_.empty(); }
  // Ties go to the lower face index. The mesh must not be empty.
  ClosestPoint closest(const Vec3f& p) const;
  // closest(p).distance for many points, on all threads. Infinite for an empty mesh.
  std::vector<float> distances(std::span<const Vec3f> points) const;

 private:
  struct Node {
    Vec3f low, high;
    uint32_t begin = 0, count = 0;  // count > 0: leaf with triangles [begin, begin + count); else children begin, begin + 1
  };
  struct Triangle {
    Vec3f a, b, c;
    uint32_t face;
  };
  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
};

}  // namespace vitrine
