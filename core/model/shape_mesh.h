// Parts of polished things that no axis turns: handles, knobs, necks. Their place and normals come from their outlines (a hull of
// the masks, smoothed) and are smooth from pixel to pixel, where those of surfels jump from one to the next.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/mesh/tri_mesh.h"
#include "core/trace/mesh_hits.h"

namespace vitrine {

class ShapeMesh {
 public:
  // `tolerance` > 0, scene units: how far surfels that show the mesh lie behind it, at most.
  ShapeMesh(TriMesh mesh, float tolerance);

  struct Entry {
    float t;       // in units of the ray's direction
    Vec3f normal;  // unit, interpolated, outwards
    uint32_t face = 0;
    float u = 0, v = 0;  // weights of its second and third corner
  };
  // Where a ray first meets it, from outside.
  std::optional<Entry> entry(const Vec3f& eye, const Vec3f& direction) const;

  // The normal of the nearest vertex, if it is within the tolerance.
  std::optional<Vec3f> near(const Vec3f& place) const;

  const TriMesh& mesh() const { return mesh_; }  // with normals
  float tolerance() const { return tolerance_; }

 private:
  TriMesh mesh_;
  float tolerance_;
  MeshHits hits_;
  std::vector<std::pair<uint64_t, uint32_t>> cells_;  // of tolerance_, with the vertices in them, ascending
};

// How entries change when vertices move along their normals.
class MeshSlopes {
 public:
  explicit MeshSlopes(const TriMesh& mesh);  // must outlive this
  // From gradients on an entry's normal (along the surface) and on its place along the normal, to displacements of the vertices;
  // added to grad [vertex].
  void add(const ShapeMesh::Entry& hit, const Vec3d& grad_normal, double grad_offset, std::vector<double>& grad) const;

 private:
  struct Corner {
    uint32_t face;
    double angle;
  };
  Vec3d at(uint32_t vertex) const { return cast<double>(mesh_.positions[vertex]); }
  const TriMesh& mesh_;
  std::vector<uint32_t> first_;  // [vertex + 1] into corners_
  std::vector<Corner> corners_;
  std::vector<double> angle_sum_;  // [vertex]
};

}  // namespace vitrine
