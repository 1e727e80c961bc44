#include "core/scene/mesh/cell_cases.h"

#include <map>
#include <optional>

namespace vitrine {

namespace {

using Loop = std::vector<uint8_t>;
using Triangle = std::array<uint8_t, 3>;

int edge_between(int a, int b) {
  const int low = a < b ? a : b, axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  return cell_edge(axis, (low >> ((axis + 1) % 3)) & 1, (low >> ((axis + 2) % 3)) & 1);
}

bool face_has_edge(int face, int edge) {
  const int axis = face / 2, side = face & 1;
  return cell_edge_axis(edge) != axis && ((cell_edge_corner(edge) >> axis) & 1) == side;
}
bool share_a_face(int e1, int e2) {
  for (int f = 0; f < 6; ++f)
    if (face_has_edge(f, e1) && face_has_edge(f, e2)) return true;
  return false;
}

// next[e]: crossing that follows e on its loop, -1 for an edge without crossing.
std::array<int, kCellEdges> successors(uint8_t inside, uint8_t joined) {
  std::array<int, kCellEdges> next;
  next.fill(-1);
  for (int f = 0; f < 6; ++f) {
    const auto& corner = cell_face_corners(f);
    const auto is_inside = [&](int i) { return (inside >> corner[i & 3]) & 1; };
    for (int i = 0; i < 4; ++i) {
      if (is_inside(i) || !is_inside(i + 1)) continue;  // walk around the face: edge i leads into the inside
      // The walk leaves the inside corners through edge j. On a joined face the segment connects to the previous exit instead:
      // the edge through which the walk left the inside before.
      int j;
      if ((joined >> f) & 1) {
        j = i + 3;
        while (is_inside(j + 1) || !is_inside(j)) j += 3;
      } else {
        j = i + 1;
        while (!(is_inside(j) && !is_inside(j + 1))) ++j;
      }
      next[edge_between(corner[i], corner[(i + 1) & 3])] = edge_between(corner[j & 3], corner[(j + 1) & 3]);
    }
  }
  return next;
}

// Triangulates loop[first..last] with diagonals that are not inside cell faces; `closing` (first,last) is a side or already
// checked.
std::optional<std::vector<Triangle>> cut(const Loop& loop, size_t first, size_t last) {
  if (last - first < 2) return std::vector<Triangle>{};
  for (size_t mid = first + 1; mid < last; ++mid) {
    if (mid - first > 1 && share_a_face(loop[first], loop[mid])) continue;
    if (last - mid > 1 && share_a_face(loop[mid], loop[last])) continue;
    auto left = cut(loop, first, mid);
    if (!left) continue;
    const auto right = cut(loop, mid, last);
    if (!right) continue;
    left->insert(left->end(), right->begin(), right->end());
    left->push_back({loop[first], loop[mid], loop[last]});
    return left;
  }
  return std::nullopt;
}

CellCase make_case(uint8_t inside, uint8_t joined) {
  CellCase result;
  std::array<int, kCellEdges> next = successors(inside, joined);
  for (int start = 0; start < kCellEdges; ++start) {
    if (next[start] < 0) continue;
    Loop loop;
    for (int e = start; next[e] >= 0;) {
      loop.push_back(static_cast<uint8_t>(e));
      const int following = next[e];
      next[e] = -1;
      e = following;
    }
    if (const auto triangles = cut(loop, 0, loop.size() - 1)) {
      result.triangles.insert(result.triangles.end(), triangles->begin(), triangles->end());
    } else {
      const uint8_t centre = static_cast<uint8_t>(kCellEdges + result.centred_loops.size());
      for (size_t i = 0; i < loop.size(); ++i) result.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], centre});
      result.centred_loops.push_back(loop);
    }
  }
  return result;
}

struct Table {
  std::array<uint8_t, 256> ambiguous;
  std::array<uint16_t, 256 * 64> number;  // index into `cases`; bits of unambiguous faces are ignored
  std::vector<CellCase> cases;

  Table() {
    for (int c = 0; c < 256; ++c) {
      ambiguous[c] = 0;
      for (int f = 0; f < 6; ++f) {
        const auto& q = cell_face_corners(f);
        const auto in = [&](int i) { return (c >> q[i]) & 1; };
        if (in(0) == in(2) && in(1) == in(3) && in(0) != in(1)) ambiguous[c] |= static_cast<uint8_t>(1 << f);
      }
      std::map<int, uint16_t> made;
      for (int joined = 0; joined < 64; ++joined) {
        const auto [entry, is_new] = made.try_emplace(joined & ambiguous[c], static_cast<uint16_t>(cases.size()));
        if (is_new) cases.push_back(make_case(static_cast<uint8_t>(c), static_cast<uint8_t>(joined & ambiguous[c])));
        number[c * 64 + joined] = entry->second;
      }
    }
  }
};

const Table& table() {
  static const Table instance;
  return instance;
}

}  // namespace

const std::array<int, 4>& cell_face_corners(int face) {
  // Side 1 of axis a is counter-clockwise in (a+1, a+2); side 0 is reversed.
  static const auto corners = [] {
    std::array<std::array<int, 4>, 6> all{};
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 2; ++side) {
        const int b = side << axis, u = 1 << ((axis + 1) % 3), v = 1 << ((axis + 2) % 3);
        all[2 * axis + side] =
            side ? std::array<int, 4>{b, b | u, b | u | v, b | v} : std::array<int, 4>{b, b | v, b | u | v, b | u};
      }
    return all;
  }();
  return corners[face];
}

uint8_t ambiguous_faces(uint8_t inside_corners) { return table().ambiguous[inside_corners]; }

const CellCase& cell_case(uint8_t inside_corners, uint8_t joined) {
  return table().cases[table().number[inside_corners * 64 + (joined & 63)]];
}

}  // namespace vitrine
