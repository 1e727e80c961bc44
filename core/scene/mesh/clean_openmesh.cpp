#include "core/scene/mesh/clean_openmesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModBaseT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include "core/foundation/base/parallel.h"
#include "core/scene/mesh/mesh_topology.h"

namespace vitrine {

namespace {

struct MeshTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using OpenTriMesh = OpenMesh::TriMesh_ArrayKernelT<MeshTraits>;

double degrees_to_cosine(double degrees) { return std::cos(degrees * std::numbers::pi / 180.0); }

// Restricts boundary vertices to collapses along a straight boundary: quadrics alone would erode boundaries.
template <class MeshT>
class ModStraightBoundary : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(ModStraightBoundary, MeshT, StraightBoundary);
  explicit ModStraightBoundary(MeshT& mesh) : Base(mesh, true) {}
  void set_min_cosine(double c) { min_cosine_ = c; }

  float collapse_priority(const CollapseInfo& ci) override {
    if (!ci.mesh.is_boundary(ci.v0)) return Base::LEGAL_COLLAPSE;
    const bool forward = ci.mesh.is_boundary(ci.v0v1), backward = ci.mesh.is_boundary(ci.v1v0);
    if (!forward && !backward) return Base::ILLEGAL_COLLAPSE;
    // Boundary neighbour of v0 on the side opposite to v1.
    const auto other = forward ? ci.mesh.from_vertex_handle(ci.mesh.prev_halfedge_handle(ci.v0v1))
                               : ci.mesh.to_vertex_handle(ci.mesh.next_halfedge_handle(ci.v1v0));
    const auto a = ci.mesh.point(ci.v0) - ci.mesh.point(other), b = ci.mesh.point(ci.v1) - ci.mesh.point(ci.v0);
    return (a | b) >= min_cosine_ * a.norm() * b.norm() ? Base::LEGAL_COLLAPSE : Base::ILLEGAL_COLLAPSE;
  }

 private:
  double min_cosine_ = 0.9;
};

// Duplicates vertices that would create an edge with three faces or a non-manifold fan.
OpenTriMesh open_mesh(const TriMesh& mesh, std::vector<uint32_t>& source) {
  OpenTriMesh out;
  source.resize(mesh.positions.size());
  std::iota(source.begin(), source.end(), 0u);
  const auto add = [&](const Vec3f& p) { return out.add_vertex(OpenMesh::Vec3d(p.x, p.y, p.z)); };
  for (const Vec3f& p : mesh.positions) add(p);
  std::vector<OpenTriMesh::VertexHandle> corners(3);
  for (const auto& f : mesh.faces) {
    if (f[0] == f[1] || f[1] == f[2] || f[2] == f[0]) continue;
    bool fits = true;
    for (size_t k = 0; k < 3; ++k) corners[k] = OpenTriMesh::VertexHandle(static_cast<int>(f[k]));
    for (size_t k = 0; k < 3; ++k) {
      const auto side = out.find_halfedge(corners[k], corners[(k + 1) % 3]);
      fits = fits && out.is_boundary(corners[k]) && (!side.is_valid() || out.is_boundary(side));
    }
    if (fits && out.add_face(corners).is_valid()) continue;
    for (size_t k = 0; k < 3; ++k) {
      corners[k] = add(mesh.positions[f[k]]);
      source.push_back(f[k]);
    }
    out.add_face(corners);
  }
  return out;
}

}  // namespace

TriMesh without_small_components(const TriMesh& mesh, const ComponentRule& rule) {
  const FaceComponents components = face_components(mesh);
  std::vector<uint32_t> order(components.faces.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return components.faces[a] > components.faces[b]; });
  if (rule.keep_largest > 0 && order.size() > static_cast<size_t>(rule.keep_largest))
    order.resize(static_cast<size_t>(rule.keep_largest));
  const double least = rule.min_fraction * static_cast<double>(mesh.faces.size());
  std::vector<uint8_t> stays(components.faces.size(), 0), keep(mesh.faces.size());
  for (uint32_t c : order) stays[c] = static_cast<double>(components.faces[c]) >= least;
  for (size_t f = 0; f < keep.size(); ++f) keep[f] = stays[components.label[f]];
  return submesh(mesh, keep);
}

void taubin_smooth(TriMesh& mesh, const TaubinDesc& desc) {
  // Flat array of vertex neighbours: all for interior vertices, only boundary (and non-manifold) edges for boundary vertices.
  const std::vector<EdgeUse> uses = sorted_edge_uses(mesh);
  const size_t n = mesh.positions.size();
  std::vector<uint8_t> on_rim(n, 0);
  const auto is_inner = [&](size_t first, size_t last) {
    return last - first == 2 && uses[first].forward != uses[first + 1].forward;
  };
  for_each_edge(uses, [&](size_t first, size_t last) {
    if (!is_inner(first, last)) on_rim[uses[first].low] = on_rim[uses[first].high] = 1;
  });
  std::vector<uint32_t> begin(n + 1, 0), neighbours;
  for (int pass = 0; pass < 2; ++pass) {  // count, then fill
    std::vector<uint32_t> at(begin.begin(), begin.end() - 1);
    for_each_edge(uses, [&](size_t first, size_t last) {
      const uint32_t ends[2] = {uses[first].low, uses[first].high};
      for (int k = 0; k < 2; ++k) {
        if (on_rim[ends[k]] && is_inner(first, last)) continue;
        if (pass == 0)
          ++begin[ends[k] + 1];
        else
          neighbours[at[ends[k]]++] = ends[1 - k];
      }
    });
    if (pass == 0) {
      std::partial_sum(begin.begin(), begin.end(), begin.begin());
      neighbours.resize(begin.back());
    }
  }
  std::vector<Vec3f> moved(n);
  for (int step = 0; step < 2 * desc.iterations; ++step) {
    const float factor = step % 2 == 0 ? desc.lambda : desc.mu;
    parallel_for(n, 8192, [&](size_t v) {
      const Vec3f& p = mesh.positions[v];
      Vec3f sum{};
      for (uint32_t i = begin[v]; i < begin[v + 1]; ++i) sum += mesh.positions[neighbours[i]] - p;
      const uint32_t degree = begin[v + 1] - begin[v];
      moved[v] = degree > 0 ? p + (factor / static_cast<float>(degree)) * sum : p;
    });
    mesh.positions.swap(moved);
  }
}

TriMesh decimated(const TriMesh& mesh, const DecimateDesc& desc) {
  using namespace OpenMesh::Decimater;
  std::vector<uint32_t> source;
  OpenTriMesh open = open_mesh(mesh, source);
  open.request_vertex_status();
  open.request_edge_status();
  open.request_halfedge_status();
  open.request_face_status();
  open.request_face_normals();
  open.update_face_normals();
  if (open.n_faces() > desc.target_faces) {
    DecimaterT<OpenTriMesh> decimater(open);
    ModQuadricT<OpenTriMesh>::Handle quadric;
    ModNormalFlippingT<OpenTriMesh>::Handle flipping;
    ModStraightBoundary<OpenTriMesh>::Handle boundary;
    decimater.add(quadric);
    decimater.add(flipping);
    decimater.add(boundary);
    decimater.module(quadric).unset_max_err();
    decimater.module(flipping).set_max_normal_deviation(static_cast<float>(desc.max_normal_turn_deg));
    decimater.module(boundary).set_min_cosine(degrees_to_cosine(desc.max_boundary_turn_deg));
    decimater.initialize();
    decimater.decimate_to_faces(0, desc.target_faces);
  }
  TriMesh all;
  for (uint32_t s : source) {
    all.positions.push_back(mesh.positions[s]);
    if (!mesh.colors.empty()) all.colors.push_back(mesh.colors[s]);
    if (!mesh.object_ids.empty()) all.object_ids.push_back(mesh.object_ids[s]);
  }
  for (const auto f : open.faces()) {
    if (open.status(f).deleted()) continue;
    std::array<uint32_t, 3> corners{};
    size_t k = 0;
    for (const auto v : open.fv_range(f)) corners[k++] = static_cast<uint32_t>(v.idx());
    all.faces.push_back(corners);
  }
  return submesh(all, std::vector<uint8_t>(all.faces.size(), 1));
}

}  // namespace vitrine
