#include "core/scene/mesh/tsdf_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/mesh/cell_cases.h"

namespace vitrine {

namespace {

constexpr int kSide = TsdfBlock::kSide;
constexpr int kPad = kSide + 3;  // voxels -1 .. 9: cells reach voxel 8, gradients one more on each side
constexpr uint16_t kNone = 0xffff;
constexpr uint32_t kCentreFlag = 0x80000000u;  // marks a face corner that is a loop centre, numbered within the block
// Minimum distance (in voxels) between crossings and grid points, to avoid zero-area triangles.
constexpr float kEdgeMargin = 0.01f;

// A block copied with its neighbourhood: access needs no branches.
struct Neighbourhood {
  std::array<float, kPad * kPad * kPad> distance, weight;
  static size_t at(int x, int y, int z) { return size_t(((z + 1) * kPad + y + 1) * kPad + x + 1); }

  Neighbourhood(const TsdfVolume& volume, const BlockCoord& c) {
    const TsdfBlock* blocks[27];
    for (int i = 0; i < 27; ++i) blocks[i] = volume.find({c.x + i % 3 - 1, c.y + i / 3 % 3 - 1, c.z + i / 9 - 1});
    const auto part = [](int v) { return v < 0 ? 0 : v < kSide ? 1 : 2; };
    for (int z = -1; z < kPad - 1; ++z)
      for (int y = -1; y < kPad - 1; ++y)
        for (int x = -1; x < kPad - 1; ++x) {
          const TsdfBlock* b = blocks[part(x) + 3 * part(y) + 9 * part(z)];
          const int i = TsdfBlock::index(x & (kSide - 1), y & (kSide - 1), z & (kSide - 1));
          distance[at(x, y, z)] = b ? b->distance[i] : 0.f;
          weight[at(x, y, z)] = b ? b->weight[i] : 0.f;
        }
  }
};

struct BlockSurface {
  std::vector<uint16_t> edge_vertex;  // [512 * 3] vertex on the edge from a voxel along an axis; empty: no vertices
  std::vector<Vec3f> positions, normals, colors;
  std::vector<Vec3f> centre_positions, centre_normals, centre_colors;
  std::vector<std::array<uint32_t, 3>> faces;
  uint32_t first_vertex = 0, first_centre = 0;
};

class Extraction {
 public:
  Extraction(const TsdfVolume& volume, const IsoDesc& desc) : volume_(volume), desc_(desc), surfaces_(volume.block_count()) {}

  TriMesh run() {
    parallel_for(surfaces_.size(), 16, [&](size_t b) { make_vertices(b); });
    number(&BlockSurface::first_vertex, &BlockSurface::positions, 0);
    parallel_for(surfaces_.size(), 16, [&](size_t b) { make_faces(b); });
    const uint32_t edge_vertices = vertex_total_;
    number(&BlockSurface::first_centre, &BlockSurface::centre_positions, edge_vertices);
    return collect();
  }

 private:
  // Numbers the vertices, blocks in order.
  void number(uint32_t BlockSurface::*first, std::vector<Vec3f> BlockSurface::*vertices, uint32_t from) {
    uint64_t total = from;
    for (BlockSurface& s : surfaces_) {
      s.*first = static_cast<uint32_t>(total);
      total += (s.*vertices).size();
    }
    if (total >= kCentreFlag)
      throw Error(ErrorKind::Resource, "the surface has too many vertices",
                  {.why = fmt::format("{} vertices", total), .hint = "lower mesh.resolution", .code = "MESH_TOO_LARGE"});
    vertex_total_ = static_cast<uint32_t>(total);
  }

  bool seen(const Neighbourhood& n, int x, int y, int z) const {
    return n.weight[Neighbourhood::at(x, y, z)] >= desc_.min_weight;
  }

  // Finite differences over observed neighbours: central, else one-sided, else zero.
  Vec3f gradient(const Neighbourhood& n, int x, int y, int z) const {
    Vec3f g{};
    const int delta[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto& [dx, dy, dz] = delta[axis];
      const bool ahead = seen(n, x + dx, y + dy, z + dz), behind = seen(n, x - dx, y - dy, z - dz);
      const float here = n.distance[Neighbourhood::at(x, y, z)];
      const float high = ahead ? n.distance[Neighbourhood::at(x + dx, y + dy, z + dz)] : here;
      const float low = behind ? n.distance[Neighbourhood::at(x - dx, y - dy, z - dz)] : here;
      g[axis] = (high - low) / float(std::max(1, int(ahead) + int(behind)));
    }
    return g;
  }

  void make_vertices(size_t b) {
    const BlockCoord& c = volume_.coord(b);
    const TsdfBlock& own = volume_.block(b);
    if (std::all_of(own.weight.begin(), own.weight.end(), [&](float w) { return w < desc_.min_weight; })) return;
    const Neighbourhood n(volume_, c);
    BlockSurface& out = surfaces_[b];
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          if (!seen(n, x, y, z)) continue;
          const float d0 = n.distance[Neighbourhood::at(x, y, z)];
          for (int axis = 0; axis < 3; ++axis) {
            const int x1 = x + (axis == 0), y1 = y + (axis == 1), z1 = z + (axis == 2);
            const float d1 = n.distance[Neighbourhood::at(x1, y1, z1)];
            if ((d0 < 0) == (d1 < 0) || !seen(n, x1, y1, z1)) continue;
            if (out.edge_vertex.empty()) out.edge_vertex.assign(size_t(TsdfBlock::kVoxels) * 3, kNone);
            out.edge_vertex[size_t(TsdfBlock::index(x, y, z) * 3 + axis)] = static_cast<uint16_t>(out.positions.size());
            const float t = std::clamp(d0 / (d0 - d1), kEdgeMargin, 1 - kEdgeMargin);
            const Vec3d p0 = volume_.voxel_position(c, x, y, z);
            Vec3d p = p0;
            p[size_t(axis)] += volume_.desc().voxel * double(t);
            out.positions.push_back(cast<float>(p));
            const Vec3f g = (1 - t) * gradient(n, x, y, z) + t * gradient(n, x1, y1, z1);
            const float len = length(g);
            Vec3f along{};
            along[size_t(axis)] = d1 > d0 ? 1.f : -1.f;
            out.normals.push_back(len > 0 ? g / len : along);
            out.colors.push_back(color(c, {x, y, z}, {x1, y1, z1}, t));
          }
        }
  }

  Vec3f color(const BlockCoord& c, const std::array<int, 3>& v0, const std::array<int, 3>& v1, float t) const {
    Vec3f sum{};
    float total = 0;
    for (int end = 0; end < 2; ++end) {
      const auto& v = end ? v1 : v0;
      const TsdfBlock* block = volume_.find({c.x + v[0] / kSide, c.y + v[1] / kSide, c.z + v[2] / kSide});
      const size_t i = size_t(TsdfBlock::index(v[0] % kSide, v[1] % kSide, v[2] % kSide));
      if (!block || !(block->color_weight[i] > 0)) continue;
      const float share = end ? t : 1 - t;
      sum += share * Vec3f{block->color[0][i], block->color[1][i], block->color[2][i]};
      total += share;
    }
    return total > 0 ? sum / total : sum;
  }

  // Sign of the bilinear saddle point of each ambiguous face: negative = inside corners joined.
  static uint8_t joined_faces(const std::array<float, 8>& d, uint8_t inside) {
    uint8_t joined = 0;
    const uint8_t ambiguous = ambiguous_faces(inside);
    for (int f = 0; ambiguous >> f; ++f) {
      if (!((ambiguous >> f) & 1)) continue;
      const auto& q = cell_face_corners(f);
      const float even = d[size_t(q[0])] * d[size_t(q[2])], odd = d[size_t(q[1])] * d[size_t(q[3])];
      const bool even_inside = (inside >> q[0]) & 1;
      if (even_inside ? even > odd : odd > even) joined |= static_cast<uint8_t>(1 << f);
    }
    return joined;
  }

  void make_faces(size_t b) {
    const BlockCoord& c = volume_.coord(b);
    const BlockSurface* around[8];
    bool any = false;
    for (int i = 0; i < 8; ++i) {
      const int32_t k = volume_.find_index({c.x + (i & 1), c.y + ((i >> 1) & 1), c.z + (i >> 2)});
      around[i] = k < 0 ? nullptr : &surfaces_[size_t(k)];
      any = any || (around[i] && !around[i]->edge_vertex.empty());
    }
    if (!any) return;
    const Neighbourhood n(volume_, c);
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) make_cell(surfaces_[b], around, n, x, y, z);
  }

  void make_cell(BlockSurface& out, const BlockSurface* const* around, const Neighbourhood& n, int x, int y, int z) const {
    std::array<float, 8> d;
    uint8_t inside = 0;
    bool all_seen = true;
    for (int i = 0; i < 8; ++i) {
      const size_t at = Neighbourhood::at(x + (i & 1), y + ((i >> 1) & 1), z + (i >> 2));
      d[size_t(i)] = n.distance[at];
      inside |= static_cast<uint8_t>((n.distance[at] < 0) << i);
      all_seen = all_seen && n.weight[at] >= desc_.min_weight;
    }
    if (!all_seen || inside == 0 || inside == 0xff) return;
    const CellCase& cell = cell_case(inside, joined_faces(d, inside));
    // Vertex of cell edge e and the block that owns it.
    const auto crossing = [&](int e) -> std::pair<const BlockSurface*, uint32_t> {
      const int corner = cell_edge_corner(e);
      const int vx = x + (corner & 1), vy = y + ((corner >> 1) & 1), vz = z + (corner >> 2);
      const BlockSurface* owner = around[vx / kSide + 2 * (vy / kSide) + 4 * (vz / kSide)];
      const int voxel = TsdfBlock::index(vx % kSide, vy % kSide, vz % kSide);
      return {owner, owner->edge_vertex[size_t(voxel * 3 + cell_edge_axis(e))]};
    };
    if (desc_.max_jump < 2.f)
      for (int e = 0; e < kCellEdges; ++e) {
        const int c0 = cell_edge_corner(e), c1 = c0 | (1 << cell_edge_axis(e));
        const float d0 = d[size_t(c0)], d1 = d[size_t(c1)];
        if ((d0 < 0) != (d1 < 0) && std::abs(d0 - d1) > desc_.max_jump) return;
      }
    const uint32_t first_centre = static_cast<uint32_t>(out.centre_positions.size());
    for (const auto& loop : cell.centred_loops) {
      Vec3f p{}, normal{}, color{};
      for (uint8_t e : loop) {
        const auto [owner, v] = crossing(e);
        p += owner->positions[v];
        normal += owner->normals[v];
        color += owner->colors[v];
      }
      const float share = 1.f / float(loop.size()), len = length(normal);
      out.centre_positions.push_back(share * p);
      out.centre_normals.push_back(len > 0 ? normal / len : Vec3f{0, 0, 1});
      out.centre_colors.push_back(share * color);
    }
    for (const auto& t : cell.triangles) {
      std::array<uint32_t, 3> face;
      for (size_t k = 0; k < 3; ++k) {
        if (t[k] >= kCellEdges) {
          face[k] = kCentreFlag | (first_centre + t[k] - kCellEdges);
          continue;
        }
        const auto [owner, v] = crossing(t[k]);
        face[k] = owner->first_vertex + v;
      }
      out.faces.push_back(face);
    }
  }

  // Concatenates the blocks without unused vertices (those of cells with an unobserved corner).
  TriMesh collect() {
    TriMesh mesh;
    std::vector<uint32_t> renumbered(vertex_total_, 0);
    for (BlockSurface& s : surfaces_)
      for (auto& face : s.faces)
        for (uint32_t& v : face) {
          if (v & kCentreFlag) v = s.first_centre + (v & ~kCentreFlag);
          renumbered[v] = 1;
        }
    uint32_t kept = 0;
    for (uint32_t& r : renumbered) {
      const bool used = r != 0;
      r = used ? kept++ : std::numeric_limits<uint32_t>::max();
    }
    mesh.positions.resize(kept);
    mesh.normals.resize(kept);
    mesh.colors.resize(kept);
    size_t face_total = 0;
    for (const BlockSurface& s : surfaces_) {
      const auto place = [&](uint32_t first, const std::vector<Vec3f>& p, const std::vector<Vec3f>& n,
                             const std::vector<Vec3f>& c) {
        for (size_t i = 0; i < p.size(); ++i) {
          const uint32_t v = renumbered[first + i];
          if (v == std::numeric_limits<uint32_t>::max()) continue;
          mesh.positions[v] = p[i];
          mesh.normals[v] = n[i];
          mesh.colors[v] = c[i];
        }
      };
      place(s.first_vertex, s.positions, s.normals, s.colors);
      place(s.first_centre, s.centre_positions, s.centre_normals, s.centre_colors);
      face_total += s.faces.size();
    }
    mesh.faces.reserve(face_total);
    for (const BlockSurface& s : surfaces_)
      for (const auto& f : s.faces) mesh.faces.push_back({renumbered[f[0]], renumbered[f[1]], renumbered[f[2]]});
    return mesh;
  }

  const TsdfVolume& volume_;
  IsoDesc desc_;
  std::vector<BlockSurface> surfaces_;
  uint32_t vertex_total_ = 0;
};

}  // namespace

TriMesh iso_surface(const TsdfVolume& volume, const IsoDesc& desc) { return Extraction(volume, desc).run(); }

}  // namespace vitrine
