#include "core/scene/mesh/repair_cgal.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include "core/foundation/base/error.h"
#include "core/scene/mesh/mesh_topology.h"

namespace vitrine {

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
using Face = SurfaceMesh::Face_index;
using Halfedge = SurfaceMesh::Halfedge_index;
using Polygon = std::vector<size_t>;

Point to_point(const Vec3f& p) { return Point(p.x, p.y, p.z); }
Vec3f to_vec(const Point& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())}; }

// Colours and normals by position: CGAL merges and duplicates vertices, but never moves them.
class AttributesByPosition {
 public:
  explicit AttributesByPosition(const TriMesh& mesh) : mesh_(mesh), order_(mesh.positions.size()) {
    for (size_t v = 0; v < order_.size(); ++v) order_[v] = static_cast<uint32_t>(v);
    std::sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) {
      const auto ka = key(mesh.positions[a]), kb = key(mesh.positions[b]);
      return ka != kb ? ka < kb : a < b;
    });
  }
  // First input vertex at this position.
  size_t vertex_at(const Vec3f& p) const {
    const auto found = std::lower_bound(order_.begin(), order_.end(), key(p),
                                        [&](uint32_t v, const auto& k) { return key(mesh_.positions[v]) < k; });
    VITRINE_CHECK(found != order_.end() && key(mesh_.positions[*found]) == key(p), "repair moved a vertex");
    return *found;
  }

 private:
  // Adding 0 converts -0 to +0.
  static std::array<float, 3> key(const Vec3f& p) { return {p.x + 0.f, p.y + 0.f, p.z + 0.f}; }
  const TriMesh& mesh_;
  std::vector<uint32_t> order_;
};

TriMesh from_surface_mesh(const SurfaceMesh& surface) {
  TriMesh out;
  std::vector<uint32_t> number(surface.num_vertices() + surface.number_of_removed_vertices(), 0);
  for (const auto v : surface.vertices()) {
    number[v.idx()] = static_cast<uint32_t>(out.positions.size());
    out.positions.push_back(to_vec(surface.point(v)));
  }
  for (const Face f : surface.faces()) {
    std::array<uint32_t, 3> corners{};
    size_t k = 0;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f))) corners[k++] = number[v.idx()];
    out.faces.push_back(corners);
  }
  return out;
}

// Orients each component by its vertex normals; without normals, faces point away from the centroid of the component.
size_t orient_components(TriMesh& mesh, const TriMesh& original, const AttributesByPosition& attributes) {
  const FaceComponents components = face_components(mesh);
  const auto corner = [&](size_t f, size_t k) { return cast<double>(mesh.positions[mesh.faces[f][k]]); };
  const auto area_vector = [&](size_t f) { return 0.5 * cross(corner(f, 1) - corner(f, 0), corner(f, 2) - corner(f, 0)); };
  const auto centroid = [&](size_t f) { return (corner(f, 0) + corner(f, 1) + corner(f, 2)) / 3.0; };
  std::vector<Vec3d> centre(components.faces.size());
  std::vector<double> area(components.faces.size(), 0), vote(components.faces.size(), 0);
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    centre[components.label[f]] += length(area_vector(f)) * centroid(f);
    area[components.label[f]] += length(area_vector(f));
  }
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const uint32_t c = components.label[f];
    Vec3d outwards{};
    if (original.normals.empty())
      outwards = centroid(f) - centre[c] / area[c];
    else
      for (uint32_t v : mesh.faces[f]) outwards += cast<double>(original.normals[attributes.vertex_at(mesh.positions[v])]);
    vote[c] += dot(area_vector(f), outwards);
  }
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    if (vote[components.label[f]] < 0) std::swap(mesh.faces[f][1], mesh.faces[f][2]);
  return static_cast<size_t>(std::count_if(vote.begin(), vote.end(), [](double v) { return v < 0; }));
}

SurfaceMesh to_surface_mesh(const TriMesh& mesh) {
  SurfaceMesh out;
  std::vector<Point> points;
  std::vector<Polygon> polygons;
  for (const Vec3f& p : mesh.positions) points.push_back(to_point(p));
  for (const auto& f : mesh.faces)
    if (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]) polygons.push_back({f[0], f[1], f[2]});
  if (!pmp::is_polygon_soup_a_polygon_mesh(polygons)) pmp::orient_polygon_soup(points, polygons);
  pmp::polygon_soup_to_polygon_mesh(points, polygons, out);
  return out;
}

void fill_holes(SurfaceMesh& surface, size_t max_edges, RepairReport& report) {
  std::vector<Halfedge> borders;
  pmp::extract_boundary_cycles(surface, std::back_inserter(borders));
  for (const Halfedge start : borders) {
    size_t edges = 0;
    for (Halfedge h = start; edges <= max_edges; h = surface.next(h)) {
      ++edges;
      if (surface.next(h) == start) break;
    }
    if (edges > max_edges) continue;
    std::vector<Face> patch;
#if CGAL_VERSION_MAJOR >= 6
    pmp::triangulate_hole(surface, start, CGAL::parameters::face_output_iterator(std::back_inserter(patch)));
#else
    pmp::triangulate_hole(surface, start, std::back_inserter(patch));
#endif
    report.filled_holes += !patch.empty();
    report.filled_faces += patch.size();
  }
}

// CGAL reports faces that touch in duplicated vertices (split non-manifold places) as intersecting. Here corners at the same
// position are one corner: the faces intersect only if a side opposite to it meets the other face.
bool really_intersect(const SurfaceMesh& surface, Face f, Face g) {
  std::array<Point, 3> a, b;
  size_t k = 0;
  for (const auto v : surface.vertices_around_face(surface.halfedge(f))) a[k++] = surface.point(v);
  k = 0;
  for (const auto v : surface.vertices_around_face(surface.halfedge(g))) b[k++] = surface.point(v);
  size_t shared = 0, i = 0, j = 0;  // the last common corner is a[i], b[j]
  for (size_t m = 0; m < 3; ++m)
    for (size_t n = 0; n < 3; ++n)
      if (a[m] == b[n]) {
        ++shared;
        i = m;
        j = n;
      }
  if (shared == 0 || shared >= 3) return true;
  if (shared == 2) {  // common side: they overlap only if folded flat
    const auto is_in = [](const Point& p, const std::array<Point, 3>& t) { return std::find(t.begin(), t.end(), p) != t.end(); };
    size_t m = 0, n = 0;
    while (is_in(a[m], b)) ++m;
    while (is_in(b[n], a)) ++n;
    return CGAL::coplanar(a[0], a[1], a[2], b[n]) &&
           CGAL::coplanar_orientation(a[(m + 1) % 3], a[(m + 2) % 3], a[m], b[n]) == CGAL::POSITIVE;
  }
  const Kernel::Triangle_3 ta(a[0], a[1], a[2]), tb(b[0], b[1], b[2]);
  return CGAL::do_intersect(ta, Kernel::Segment_3(b[(j + 1) % 3], b[(j + 2) % 3])) ||
         CGAL::do_intersect(tb, Kernel::Segment_3(a[(i + 1) % 3], a[(i + 2) % 3]));
}

std::vector<std::pair<Face, Face>> intersecting_pairs(const SurfaceMesh& surface) {
  std::vector<std::pair<Face, Face>> pairs;
  pmp::self_intersections(surface, std::back_inserter(pairs));
  std::erase_if(pairs, [&](const auto& p) { return !really_intersect(surface, p.first, p.second); });
  return pairs;
}

// Intersecting faces, unique and sorted.
std::vector<Face> intersecting_faces(const SurfaceMesh& surface) {
  std::vector<Face> faces;
  for (const auto& [a, b] : intersecting_pairs(surface)) {
    faces.push_back(a);
    faces.push_back(b);
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

}  // namespace

TriMesh repaired(const TriMesh& mesh, const RepairDesc& desc, RepairReport* report) {
  RepairReport unused, &r = report ? *report : unused;
  r = {};
  // 1. Polygon soup: merge equal positions, remove degenerate and duplicate faces, orient consistently.
  std::vector<Point> points;
  std::vector<Polygon> polygons;
  points.reserve(mesh.positions.size());
  polygons.reserve(mesh.faces.size());
  for (const Vec3f& p : mesh.positions) points.push_back(to_point(p));
  for (const auto& f : mesh.faces) {
    const Point &a = points[f[0]], &b = points[f[1]], &c = points[f[2]];
    if (!CGAL::collinear(a, b, c)) polygons.push_back({f[0], f[1], f[2]});
  }
  pmp::remove_isolated_points_in_polygon_soup(points, polygons);
  r.duplicate_vertices = pmp::merge_duplicate_points_in_polygon_soup(points, polygons);
  pmp::merge_duplicate_polygons_in_polygon_soup(points, polygons, CGAL::parameters::require_same_orientation(false));
  r.dropped_faces = mesh.faces.size() - polygons.size();
  pmp::orient_polygon_soup(points, polygons);

  TriMesh soup;
  for (const Point& p : points) soup.positions.push_back(to_vec(p));
  for (const Polygon& p : polygons)
    soup.faces.push_back({static_cast<uint32_t>(p[0]), static_cast<uint32_t>(p[1]), static_cast<uint32_t>(p[2])});
  const AttributesByPosition attributes(mesh);
  r.flipped_components = orient_components(soup, mesh, attributes);

  // 2. Mesh: fill holes, then repeatedly remove intersecting faces and fill the gaps. The last step is removal.
  SurfaceMesh surface = to_surface_mesh(soup);
  if (desc.max_hole_edges > 0) fill_holes(surface, desc.max_hole_edges, r);
  for (int round = 0; round <= desc.intersection_rounds; ++round) {
    const std::vector<Face> bad = intersecting_faces(surface);
    if (bad.empty()) break;
    r.intersecting_faces += bad.size();
    for (const Face f : bad) CGAL::Euler::remove_face(surface.halfedge(f), surface);
    pmp::remove_isolated_vertices(surface);
    pmp::duplicate_non_manifold_vertices(surface);
    if (round < desc.intersection_rounds && desc.max_hole_edges > 0) fill_holes(surface, desc.max_hole_edges, r);
  }
  TriMesh out = from_surface_mesh(surface);
  if (!mesh.colors.empty())
    for (const Vec3f& p : out.positions) out.colors.push_back(mesh.colors[attributes.vertex_at(p)]);
  return out;
}

size_t self_intersection_count(const TriMesh& mesh) { return intersecting_pairs(to_surface_mesh(mesh)).size(); }

}  // namespace vitrine
