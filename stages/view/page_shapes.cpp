#include "stages/view/page_blocks.h"

#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/render/model/pane_pass.h"

namespace vitrine {

namespace {

constexpr double kSpacing_rel = 1.0 / 24;  // edge length of curved shapes, relative to their size
constexpr size_t kMostFaces = 6000;        // per shape
constexpr uint16_t kCurved = UINT16_MAX;
constexpr const char* kRoles[] = {"mirror", "sheet", "coat", "sheet"};  // [ShapeRole]; the page does not refract at solid glass

uint16_t facet_of(std::span<const Facet> facets, const Vec3d& normal) {
  size_t best = 0;
  for (size_t i = 1; i < facets.size(); ++i)
    if (dot(facets[i].normal, normal) > dot(facets[best].normal, normal)) best = i;
  return static_cast<uint16_t>(best);
}

}  // namespace

nlohmann::ordered_json add_shapes(const ShapeSet* set, PageBlocks& blocks) {
  nlohmann::ordered_json entries = nlohmann::ordered_json::array(), planes = nlohmann::ordered_json::array();
  std::vector<float> places, normals;
  std::vector<uint16_t> parts;
  std::vector<uint32_t> corners;
  const auto add = [&](const Vec3f& p, const Vec3f& n, size_t entry, uint16_t facet) {
    places.insert(places.end(), {p.x, p.y, p.z});
    normals.insert(normals.end(), {n.x, n.y, n.z});
    parts.insert(parts.end(), {facet, static_cast<uint16_t>(entry)});
  };
  for (size_t number = 0; set != nullptr && number < set->entries.size(); ++number) {
    const ShapeSet::Entry& e = set->entries[number];
    const std::vector<Facet> flat = facets(e.shape);
    const auto first = static_cast<uint16_t>(planes.size());
    for (size_t i = 0; i < flat.size(); ++i) {
      const Facet& f = flat[i];
      planes.push_back({{"entry", number},
                        {"normal", {f.normal.x, f.normal.y, f.normal.z}},
                        {"offset", f.offset},
                        {"clear", e.is_clear(i)},
                        {"at_pane", kAtPane_rel * e.tolerance}});
    }
    entries.push_back({{"role", kRoles[static_cast<size_t>(e.role)]},
                       {"tolerance", e.tolerance},
                       {"closed", !std::holds_alternative<Plane>(e.shape)},
                       {"exact", e.exact},
                       {"parent", e.parent},
                       {"object", e.object}});
    TriMesh mesh = tessellated(e.shape, kSpacing_rel * size_of(e.shape));
    if (mesh.faces.size() > kMostFaces) mesh = decimated(mesh, {.target_faces = kMostFaces});
    const std::vector<Vec3f> smooth = vertex_normals(mesh);
    if (flat.empty()) {
      const auto base = static_cast<uint32_t>(places.size() / 3);
      for (size_t v = 0; v < mesh.positions.size(); ++v) add(mesh.positions[v], smooth[v], number, kCurved);
      for (const auto& face : mesh.faces)
        for (const uint32_t v : face) corners.push_back(base + v);
      continue;
    }
    for (const auto& face : mesh.faces) {
      const Vec3f &a = mesh.positions[face[0]], &b = mesh.positions[face[1]], &c = mesh.positions[face[2]];
      const Vec3f across = normalized(cross(b - a, c - a));
      const auto facet = static_cast<uint16_t>(first + facet_of(flat, cast<double>(across)));
      for (const uint32_t v : face) {
        corners.push_back(static_cast<uint32_t>(places.size() / 3));
        add(mesh.positions[v], across, number, facet);
      }
    }
  }
  blocks.floats("shape_place", places, 3);
  blocks.halves("shape_normal", normals, 3);
  blocks.words("shape_part", parts, 2);
  blocks.indices("shape_corner", corners, 3);
  return {{"entries", entries}, {"facets", planes}};
}

}  // namespace vitrine
