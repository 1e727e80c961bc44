#include "stages/export/bake/atlas.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <unordered_map>

#include "core/foundation/base/error.h"
#include "core/foundation/math/rigid.h"
#include "stages/export/bake/texels.h"

namespace vitrine {

namespace {

constexpr float kGrowCosine = 0.5f;    // between the normals of face and chart during growth: 60 degrees
constexpr float kMergeCosine = 0.17f;  // when a small chart is merged into its neighbour: 80 degrees
constexpr size_t kCrumbFaces = 6;      // charts with fewer faces are merged if possible
constexpr int kSmoothings = 4;
constexpr int kPadding = 2;  // free texels around each chart

Vec3f safe_normalized(const Vec3f& v, const Vec3f& otherwise) {
  const float l = length(v);
  return l > 1e-20f ? v / l : otherwise;
}

// Occupied texels per chart, as bit masks in tiles of 32 x 32.
class Occupancy {
 public:
  bool taken(uint32_t chart, int x, int y) const {
    const auto it = tiles_.find(key(chart, x, y));
    return it != tiles_.end() && (it->second[size_t(y & 31)] >> (x & 31) & 1u);
  }
  void take(uint32_t chart, int x, int y) { tiles_[key(chart, x, y)][size_t(y & 31)] |= 1u << (x & 31); }

 private:
  static uint64_t key(uint32_t chart, int x, int y) {
    constexpr int kHalf = 1 << 15;  // tiles: coordinates may be negative
    return uint64_t(chart) << 32 | uint64_t((x >> 5) + kHalf) << 16 | uint64_t((y >> 5) + kHalf);
  }
  std::unordered_map<uint64_t, std::array<uint32_t, 32>> tiles_;
};

class ChartMaker {
 public:
  ChartMaker(const TriMesh& mesh, Atlas& atlas) : mesh_(mesh), atlas_(atlas), neighbours_(neighbour_faces(mesh)) {
    measure_normals();
    centre_ = mesh.positions[mesh.faces[0][0]];  // near the faces: keeps texel coordinates small
  }

  void run() {
    const size_t n = mesh_.faces.size();
    atlas_.chart_of_face.assign(n, kNoFace);
    for (uint32_t f = 0; f < n; ++f) {
      if (atlas_.chart_of_face[f] != kNoFace) continue;
      // The first growth finds the region, the second starts from its mean normal.
      Vec3f sum{};
      for (uint32_t g : grown(f, frame_of(smooth_[f]), false)) sum += area_[g] * normal_[g];
      const Vec3f mean = safe_normalized(sum, normal_[f]);
      const AtlasChart chart = frame_of(dot(mean, normal_[f]) > kGrowCosine ? mean : normal_[f]);
      atlas_.charts.push_back(chart);
      sizes_.push_back(grown(f, chart, true).size());
    }
    give_away_crumbs();
  }

 private:
  void measure_normals() {
    const size_t n = mesh_.faces.size();
    normal_.resize(n), area_.resize(n), smooth_.resize(n);
    for (size_t f = 0; f < n; ++f) {
      const auto& v = mesh_.faces[f];
      const Vec3f c = cross(mesh_.positions[v[1]] - mesh_.positions[v[0]], mesh_.positions[v[2]] - mesh_.positions[v[0]]);
      area_[f] = 0.5f * length(c);
      normal_[f] = safe_normalized(c, {0, 0, 1});
    }
    smooth_ = normal_;
    for (int i = 0; i < kSmoothings; ++i) {
      std::vector<Vec3f> at_vertex(mesh_.positions.size(), Vec3f{});
      for (size_t f = 0; f < n; ++f)
        for (uint32_t v : mesh_.faces[f]) at_vertex[v] += area_[f] * smooth_[f];
      for (size_t f = 0; f < n; ++f) {
        const auto& v = mesh_.faces[f];
        smooth_[f] = safe_normalized(at_vertex[v[0]] + at_vertex[v[1]] + at_vertex[v[2]], normal_[f]);
      }
    }
  }

  static AtlasChart frame_of(const Vec3f& normal) {
    // Keeps world up as texture up where possible.
    const Vec3f up_hint = std::abs(normal.z) < 0.9f ? Vec3f{0, 0, 1} : Vec3f{0, 1, 0};
    const Vec3f u = normalized(cross(up_hint, normal));
    return {.u = u, .up = cross(normal, u), .normal = normal};
  }

  // Marks the face's texels in the chart if all are free; otherwise returns false.
  bool take_texels(uint32_t face, uint32_t chart, const AtlasChart& frame) {
    Vec2f corner[3];
    for (size_t k = 0; k < 3; ++k) {
      const Vec3f p = mesh_.positions[mesh_.faces[face][k]] - centre_;
      corner[k] = {atlas_.texels_per_unit * dot(p, frame.u), -atlas_.texels_per_unit * dot(p, frame.up)};
    }
    bool free = true;
    for_texels_of(corner, [&](int x, int y, const Vec3f&) { free = free && !occupancy_.taken(chart, x, y); });
    if (free) for_texels_of(corner, [&](int x, int y, const Vec3f&) { occupancy_.take(chart, x, y); });
    return free;
  }

  // Faces reached from the seed. `keep`: assigns them to the newest chart; otherwise a dry run.
  std::vector<uint32_t> grown(uint32_t seed, const AtlasChart& frame, bool keep) {
    const auto chart = uint32_t(atlas_.charts.size() - (keep ? 1 : 0));
    std::vector<uint32_t> faces;
    const auto admit = [&](uint32_t f) {
      if (atlas_.chart_of_face[f] != kNoFace || visited_[f] == visit_) return;
      visited_[f] = visit_;
      if (f != seed && !(dot(normal_[f], frame.normal) > kGrowCosine)) return;
      if (keep && !take_texels(f, chart, frame)) return;
      faces.push_back(f);
    };
    visited_.resize(mesh_.faces.size(), 0);
    ++visit_;
    admit(seed);
    const size_t enough = keep ? mesh_.faces.size() : 400;
    for (size_t i = 0; i < faces.size() && faces.size() < enough; ++i)
      for (uint32_t g : neighbours_[faces[i]])
        if (g != kNoFace) admit(g);
    if (keep)
      for (uint32_t f : faces) atlas_.chart_of_face[f] = chart;
    return faces;
  }

  void give_away_crumbs() {
    for (int pass = 0; pass < 3; ++pass)
      for (uint32_t f = 0; f < mesh_.faces.size(); ++f) {
        const uint32_t own = atlas_.chart_of_face[f];
        if (sizes_[own] >= kCrumbFaces) continue;
        for (uint32_t g : neighbours_[f]) {
          if (g == kNoFace) continue;
          const uint32_t other = atlas_.chart_of_face[g];
          if (other == own || sizes_[other] < kCrumbFaces) continue;
          const AtlasChart& frame = atlas_.charts[other];
          if (!(dot(normal_[f], frame.normal) > kMergeCosine) || !take_texels(f, other, frame)) continue;
          --sizes_[own], ++sizes_[other];
          atlas_.chart_of_face[f] = other;
          break;
        }
      }
    // Removes empty charts.
    std::vector<uint32_t> moved(atlas_.charts.size());
    uint32_t kept = 0;
    for (uint32_t c = 0; c < atlas_.charts.size(); ++c) {
      if (sizes_[c] == 0) continue;
      atlas_.charts[kept] = atlas_.charts[c];
      moved[c] = kept++;
    }
    atlas_.charts.resize(kept);
    for (uint32_t& c : atlas_.chart_of_face) c = moved[c];
  }

  const TriMesh& mesh_;
  Atlas& atlas_;
  std::vector<std::array<uint32_t, 3>> neighbours_;
  Vec3f centre_{};
  std::vector<Vec3f> normal_, smooth_;
  std::vector<float> area_;
  std::vector<size_t> sizes_;  // faces per chart
  Occupancy occupancy_;
  std::vector<uint32_t> visited_;
  uint32_t visit_ = 0;
};

struct Extent {
  Vec2f low{1e30f, 1e30f}, high{-1e30f, -1e30f};  // scene units along u and up
  Vec2f size() const { return high - low; }
};

Extent extent(std::span<const Vec3f> points, const Vec3f& u, const Vec3f& up) {
  Extent e;
  for (const Vec3f& p : points) {
    const float a = dot(p, u), b = dot(p, up);
    e.low = {std::min(e.low.x, a), std::min(e.low.y, b)};
    e.high = {std::max(e.high.x, a), std::max(e.high.y, b)};
  }
  return e;
}

// Rotates the chart's frame about its normal to the smallest of 16 rectangles, the long side along u.
Extent turned_to_smallest(AtlasChart& chart, std::span<const Vec3f> points) {
  Extent best;
  Vec3f best_u = chart.u, best_up = chart.up;
  float best_area = 1e30f;
  constexpr int kTurns = 16;
  for (int i = 0; i < kTurns; ++i) {
    const float angle = float(M_PI) * float(i) / kTurns;
    const Vec3f u = std::cos(angle) * chart.u + std::sin(angle) * chart.up, up = cross(chart.normal, u);
    const Extent e = extent(points, u, up);
    const Vec2f s = e.size();
    // Requires an improvement of 10 % over the first; only landscape rectangles, which pack well.
    if (s.x < s.y || !(s.x * s.y < (i == 0 ? 1e30f : 0.9f * best_area))) continue;
    best = e, best_u = u, best_up = up, best_area = s.x * s.y;
  }
  chart.u = best_u, chart.up = best_up;
  return best_area < 1e30f ? best : extent(points, best_u, best_up);
}

// Skyline packing: rectangles by descending height, each at the position with the highest upper side in the texture (rows go
// down, the skyline is the lower border of the occupied area). False: they do not fit.
bool packed(std::vector<AtlasChart>& charts, int size) {
  std::vector<uint32_t> order(charts.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, [&](uint32_t a, uint32_t b) { return charts[a].height > charts[b].height; });
  struct Step {
    int x, y;  // up to the next step, rows below y are free
  };
  std::vector<Step> sky{{0, 0}};
  for (uint32_t i : order) {
    AtlasChart& c = charts[i];
    size_t best = sky.size();
    int best_y = size - c.height + 1;
    for (size_t s = 0; s < sky.size() && sky[s].x + c.width <= size; ++s) {
      int y = 0;
      for (size_t t = s; t < sky.size() && sky[t].x < sky[s].x + c.width; ++t) y = std::max(y, sky[t].y);
      if (y < best_y) best = s, best_y = y;
    }
    if (best == sky.size()) return false;
    c.x = sky[best].x, c.y = best_y;
    // The covered steps become one; the last one continues to the right of the rectangle.
    size_t end = best;
    while (end < sky.size() && sky[end].x < c.x + c.width) ++end;
    const int behind = sky[end - 1].y, next = end < sky.size() ? sky[end].x : size;
    sky.erase(sky.begin() + long(best), sky.begin() + long(end));
    sky.insert(sky.begin() + long(best), {c.x, c.y + c.height});
    if (c.x + c.width < next) sky.insert(sky.begin() + long(best) + 1, {c.x + c.width, behind});
  }
  return true;
}

float diagonal(const TriMesh& mesh) {
  Bounds3 box;
  for (const auto& f : mesh.faces)
    for (uint32_t v : f) box.extend(cast<double>(mesh.positions[v]));
  return float(box.diagonal());
}

double total_area(const TriMesh& mesh) {
  double area = 0;
  for (const auto& v : mesh.faces)
    area += 0.5 * double(length(cross(mesh.positions[v[1]] - mesh.positions[v[0]], mesh.positions[v[2]] - mesh.positions[v[0]])));
  return area;
}

int size_for(const TriMesh& mesh) {
  constexpr double kTexelsPerEdge = 4, kUsed = 0.5;
  // Equilateral faces: area = sqrt(3)/4 edge^2. The area of the mesh cancels.
  const double texels = double(mesh.faces.size()) * 0.433 * kTexelsPerEdge * kTexelsPerEdge / kUsed;
  const auto side = uint32_t(std::clamp(std::sqrt(texels), 256.0, 4096.0));
  return int(std::bit_ceil(side));
}

}  // namespace

std::vector<std::array<uint32_t, 3>> neighbour_faces(const TriMesh& mesh) {
  struct Side {
    uint64_t edge;
    uint32_t face, k;
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.faces.size());
  for (uint32_t f = 0; f < mesh.faces.size(); ++f)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
      sides.push_back({uint64_t(std::min(a, b)) << 32 | std::max(a, b), f, k});
    }
  std::ranges::sort(sides, [](const Side& a, const Side& b) { return a.edge != b.edge ? a.edge < b.edge : a.face < b.face; });
  std::vector<std::array<uint32_t, 3>> out(mesh.faces.size(), {kNoFace, kNoFace, kNoFace});
  for (size_t i = 0; i < sides.size();) {
    size_t j = i;
    while (j < sides.size() && sides[j].edge == sides[i].edge) ++j;
    if (j == i + 2) {
      out[sides[i].face][sides[i].k] = sides[i + 1].face;
      out[sides[i + 1].face][sides[i + 1].k] = sides[i].face;
    }
    i = j;
  }
  return out;
}

Atlas make_atlas(const TriMesh& mesh, int size) {
  VITRINE_CHECK(!mesh.faces.empty(), "an atlas needs faces");
  Atlas atlas;
  atlas.size = size > 0 ? size : size_for(mesh);
  const double area = std::max(total_area(mesh), 1e-12);
  // Degenerate thin faces have length but almost no area: the length limits the texel density too.
  atlas.texels_per_unit =
      std::min(float(double(atlas.size) * std::sqrt(0.75 / area)), 4 * float(atlas.size) / std::max(diagonal(mesh), 1e-12f));
  ChartMaker(mesh, atlas).run();

  std::vector<std::vector<Vec3f>> points(atlas.charts.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    for (uint32_t v : mesh.faces[f]) points[atlas.chart_of_face[f]].push_back(mesh.positions[v]);
  std::vector<Extent> extents;
  for (size_t c = 0; c < atlas.charts.size(); ++c) extents.push_back(turned_to_smallest(atlas.charts[c], points[c]));

  // Largest texel size that fits. Thousands of small charts are mostly padding, which is then reduced.
  constexpr float kShrink = 0.96f;
  const float first = atlas.texels_per_unit;
  for (int padding = kPadding;; atlas.texels_per_unit *= kShrink) {
    if (atlas.texels_per_unit < 0.05f * first && padding > 0) --padding, atlas.texels_per_unit = first;
    if (!(atlas.texels_per_unit > 1e-4f * first))
      throw Error(ErrorKind::Usage, "the textures are too small for this mesh",
                  {.where = "texture_size",
                   .why = fmt::format("it comes apart into {} pieces, which do not fit into {} x {} texels", atlas.charts.size(),
                                      atlas.size, atlas.size),
                   .hint = fmt::format("texture_size={} or more, or fewer faces: --set mesh.faces=N",
                                       std::bit_ceil(uint32_t(4 * std::sqrt(double(atlas.charts.size()))))),
                   .code = "TEXTURE_TOO_SMALL"});
    for (size_t c = 0; c < atlas.charts.size(); ++c) {
      const Vec2f s = atlas.texels_per_unit * extents[c].size();
      atlas.charts[c].width = int(std::ceil(s.x)) + 2 * padding + 1;
      atlas.charts[c].height = int(std::ceil(s.y)) + 2 * padding + 1;
    }
    if (!packed(atlas.charts, atlas.size)) continue;
    for (size_t c = 0; c < atlas.charts.size(); ++c) {
      AtlasChart& chart = atlas.charts[c];
      chart.origin = {float(chart.x + padding) + 0.5f - atlas.texels_per_unit * extents[c].low.x,
                      float(chart.y + padding) + 0.5f + atlas.texels_per_unit * extents[c].high.y};
    }
    return atlas;
  }
}

std::vector<AtlasTexel> covered_texels(const Atlas& atlas, const TriMesh& mesh) {
  const auto size = size_t(atlas.size);
  std::vector<uint32_t> owner(size * size, kNoFace);
  std::vector<AtlasTexel> texels;
  for (uint32_t f = 0; f < mesh.faces.size(); ++f) {
    Vec2f corner[3];
    for (size_t k = 0; k < 3; ++k) corner[k] = atlas.texel(atlas.chart_of_face[f], mesh.positions[mesh.faces[f][k]]);
    for_texels_of(corner, [&](int x, int y, const Vec3f& barycentric) {
      if (x < 0 || y < 0 || x >= atlas.size || y >= atlas.size) return;
      uint32_t& o = owner[size_t(y) * size + size_t(x)];
      if (o != kNoFace) return;
      o = f;
      texels.push_back({uint32_t(x), uint32_t(y), f, barycentric});
    });
  }
  std::ranges::sort(texels, [](const AtlasTexel& a, const AtlasTexel& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
  return texels;
}

}  // namespace vitrine
