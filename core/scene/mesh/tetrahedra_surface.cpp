#include "core/scene/mesh/tetrahedra_surface.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

// One vertex per edge that changes sign, numbered in the order of its first use.
class Crossings {
 public:
  Crossings(const Tetrahedra& t, TriMesh& mesh) : t_(t), mesh_(mesh) {}

  uint32_t of(uint32_t a, uint32_t b) {
    const uint64_t low = std::min(a, b), high = std::max(a, b);
    const auto [found, fresh] = number_.try_emplace(low << 32 | high, static_cast<uint32_t>(mesh_.positions.size()));
    if (fresh) {
      const double from = t_.values[low], to = t_.values[high];
      const double along = std::clamp(from / (from - to), kLeastCrossing, 1 - kLeastCrossing);
      mesh_.positions.push_back(cast<float>((1 - along) * t_.positions[low] + along * t_.positions[high]));
    }
    return found->second;
  }

 private:
  const Tetrahedra& t_;
  TriMesh& mesh_;
  std::unordered_map<uint64_t, uint32_t> number_;
};

// Whether the corners became ascending by an odd number of swaps.
bool sort_corners(std::array<uint32_t, 4>& v) {
  bool odd = false;
  for (size_t end = 3; end > 0; --end)
    for (size_t i = 0; i < end; ++i)
      if (v[i] > v[i + 1]) {
        std::swap(v[i], v[i + 1]);
        odd = !odd;
      }
  return odd;
}

// Cells in an order that depends on their vertices alone: containers of triangulations reuse places in any order.
std::vector<std::array<uint32_t, 4>> in_order(std::vector<std::array<uint32_t, 4>> cells) {
  for (auto& v : cells)
    if (sort_corners(v)) std::swap(v[2], v[3]);  // keeps the orientation
  std::sort(cells.begin(), cells.end());
  return cells;
}

}  // namespace

TriMesh zero_level(const Tetrahedra& t) {
  VITRINE_CHECK(t.positions.size() == t.values.size(), "one value per vertex");
  TriMesh mesh;
  Crossings crossings(t, mesh);
  for (std::array<uint32_t, 4> v : in_order(t.cells)) {
    const auto inside = [&](uint32_t i) { return t.values[i] < 0; };
    // The inside corners first, by an even number of swaps: the orientation stays.
    size_t count = 0;
    for (uint32_t i : v) count += inside(i);
    if (count == 0 || count == 4) continue;
    bool odd = false;
    for (size_t place = 0; place < count; ++place) {
      size_t at = place;
      while (!inside(v[at])) ++at;
      if (at != place) {
        std::swap(v[place], v[at]);
        odd = !odd;
      }
    }
    if (odd) count == 3 ? std::swap(v[0], v[1]) : std::swap(v[2], v[3]);
    if (count == 1) {
      mesh.faces.push_back({crossings.of(v[0], v[1]), crossings.of(v[0], v[2]), crossings.of(v[0], v[3])});
    } else if (count == 3) {
      mesh.faces.push_back({crossings.of(v[0], v[3]), crossings.of(v[1], v[3]), crossings.of(v[2], v[3])});
    } else {
      const uint32_t ac = crossings.of(v[0], v[2]), ad = crossings.of(v[0], v[3]);
      const uint32_t bc = crossings.of(v[1], v[2]), bd = crossings.of(v[1], v[3]);
      mesh.faces.push_back({ac, ad, bd});
      mesh.faces.push_back({ac, bd, bc});
    }
  }
  return mesh;
}

}  // namespace vitrine
