// Point-to-mesh distance and uniform surface sampling. Accuracy = distances from samples of the result to the ground truth;
// completeness = the reverse. Uses a bounding volume hierarchy (median split of the longest side); results do not depend on the
// number of threads.
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

// n points, uniform by area: systematic sampling of the cumulative area, random inside each triangle. Empty if the area is 0.
SurfaceSamples sample_surface(const TriMesh& mesh, size_t n, uint64_t seed);

struct ClosestPoint {
  Vec3f position{};
  uint32_t face = 0;
  float distance = 0;
};

class MeshDistance {
 public:
  // Copies the triangles. Faces of zero area are treated as segments or points.
  explicit MeshDistance(const TriMesh& mesh);

  bool empty() const { return triangles_.empty(); }
  // Ties: lower face index. The mesh must not be empty.
  ClosestPoint closest(const Vec3f& p) const;
  // closest(p).distance for many points, multi-threaded. Infinite for an empty mesh.
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
