#include "core/scene/mesh/mesh_topology.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/foundation/base/error.h"
#include "core/foundation/math/connected_components.h"

namespace vitrine {

std::vector<EdgeUse> sorted_edge_uses(const TriMesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
      if (a != b) uses.push_back({std::min(a, b), std::max(a, b), static_cast<uint32_t>(f), a < b});
    }
  std::sort(uses.begin(), uses.end());
  return uses;
}

FaceComponents face_components(const TriMesh& mesh) {
  DisjointSets sets(mesh.faces.size());
  const std::vector<EdgeUse> uses = sorted_edge_uses(mesh);
  for_each_edge(uses, [&](size_t first, size_t last) {
    for (size_t i = first + 1; i < last; ++i) sets.unite(uses[first].face, uses[i].face);
  });
  FaceComponents c;
  c.label.resize(mesh.faces.size());
  for (uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const uint32_t r = sets.representative(f);  // the first face of its component
    if (r == f) {
      c.label[f] = static_cast<uint32_t>(c.faces.size());
      c.faces.push_back(0);
    } else {
      c.label[f] = c.label[r];
    }
    ++c.faces[c.label[f]];
  }
  return c;
}

TriMesh submesh(const TriMesh& mesh, std::span<const uint8_t> keep) {
  VITRINE_CHECK(keep.size() == mesh.faces.size(), "one flag per face");
  constexpr uint32_t kUnused = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> number(mesh.positions.size(), kUnused);
  for (size_t f = 0; f < keep.size(); ++f)
    if (keep[f])
      for (uint32_t v : mesh.faces[f]) number[v] = 0;
  TriMesh out;
  for (size_t v = 0; v < number.size(); ++v) {
    if (number[v] == kUnused) continue;
    number[v] = static_cast<uint32_t>(out.positions.size());
    out.positions.push_back(mesh.positions[v]);
    if (!mesh.normals.empty()) out.normals.push_back(mesh.normals[v]);
    if (!mesh.colors.empty()) out.colors.push_back(mesh.colors[v]);
    if (!mesh.object_ids.empty()) out.object_ids.push_back(mesh.object_ids[v]);
  }
  for (size_t f = 0; f < keep.size(); ++f)
    if (keep[f]) out.faces.push_back({number[mesh.faces[f][0]], number[mesh.faces[f][1]], number[mesh.faces[f][2]]});
  return out;
}

std::vector<Vec3f> vertex_normals(const TriMesh& mesh) {
  std::vector<Vec3d> sums(mesh.positions.size());
  for (const auto& f : mesh.faces) {
    const Vec3d p[3] = {cast<double>(mesh.positions[f[0]]), cast<double>(mesh.positions[f[1]]),
                        cast<double>(mesh.positions[f[2]])};
    const Vec3d n = cross(p[1] - p[0], p[2] - p[0]);
    const double len = length(n);
    if (!(len > 0)) continue;
    for (size_t k = 0; k < 3; ++k) {
      const Vec3d u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
      sums[f[k]] += (std::atan2(len, dot(u, v)) / len) * n;
    }
  }
  std::vector<Vec3f> normals(mesh.positions.size());
  for (size_t v = 0; v < sums.size(); ++v) {
    const double len = length(sums[v]);
    normals[v] = len > 0 ? cast<float>(sums[v] / len) : Vec3f{0, 0, 1};
  }
  return normals;
}

VertexNeighbours::VertexNeighbours(const TriMesh& mesh) : first(mesh.positions.size() + 1, 0) {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (const auto& f : mesh.faces)
    for (size_t c = 0; c < 3; ++c) {
      edges.emplace_back(f[c], f[(c + 1) % 3]);
      edges.emplace_back(f[(c + 1) % 3], f[c]);
    }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& [from, to] : edges) ++first[from + 1], vertex.push_back(to);
  for (size_t v = 0; v + 1 < first.size(); ++v) first[v + 1] += first[v];
}

}  // namespace vitrine
