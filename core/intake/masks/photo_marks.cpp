#include "core/intake/masks/photo_marks.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/foundation/config/photo_name_finder.h"
#include "core/foundation/config/text.h"

namespace vitrine {

namespace {

// Twice the signed area of a triangle, positive for clockwise order on the screen.
double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

// First pair of crossing sides, each by its first corner; touching sides do not count. Sides are sorted by their left ends to
// skip most pairs.
std::optional<std::pair<size_t, size_t>> crossing_sides(const std::vector<Vec2d>& corners) {
  const size_t n = corners.size();
  const auto end = [&](size_t i) -> const Vec2d& { return corners[(i + 1) % n]; };
  const auto left = [&](size_t i) { return std::min(corners[i].x, end(i).x); };
  std::vector<size_t> order(n);
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, {}, left);
  for (size_t k = 0; k < n; ++k)
    for (size_t l = k + 1; l < n; ++l) {
      const auto [i, j] = std::minmax(order[k], order[l]);
      if (left(order[l]) > std::max(corners[order[k]].x, end(order[k]).x)) break;
      const Vec2d &a = corners[i], &b = end(i), &c = corners[j], &d = end(j);
      if (turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0) return std::pair{i, j};
    }
  return std::nullopt;
}

double area(const std::vector<Vec2d>& corners) {
  double twice = 0;
  for (size_t i = 1; i + 1 < corners.size(); ++i) twice += turn(corners[0], corners[i], corners[i + 1]);
  return std::abs(twice) / 2;
}

}  // namespace

std::optional<size_t> marked_view(YamlReader& in, const YamlNode& name, std::span<const View> views) {
  std::vector<std::string> names;
  for (const View& view : views) names.push_back(view.name);
  const PhotoNameFinder finder(names);
  const PhotoMatch meant = finder.match(name.text);
  if (meant.photo) return meant.photo;
  if (!meant.could_be.empty()) {
    in.complain(name, fmt::format("'{}' may be {}: write all of its name", name.text, listed(finder, meant.could_be)));
    return std::nullopt;
  }
  const std::string near = nearest_word(name.text, names);
  in.complain(name, fmt::format("'{}' is not among the photos that have a camera{}", name.text,
                                near.empty() ? "" : fmt::format(": did you mean '{}'?", near)));
  return std::nullopt;
}

std::optional<MarkedRegion> marked_region(YamlReader& in, const YamlNode& mark) {
  const YamlNode *box = mark.find("box"), *polygon = mark.find("polygon");
  if ((box == nullptr) == (polygon == nullptr)) {
    in.complain(mark, "a mark has a box or a polygon");
    return std::nullopt;
  }
  if (box != nullptr) {
    const auto b = in.numbers(*box, 4, "[left, top, right, bottom]");
    if (!b) return std::nullopt;
    const double l = (*b)[0], t = (*b)[1], r = (*b)[2], d = (*b)[3];
    if (l < r && t < d) return MarkedRegion{{{l, t}, {r, t}, {r, d}, {l, d}}, true};
    in.complain(*box, "left must be smaller than right, and top than bottom");
    return std::nullopt;
  }
  if (polygon->kind != YamlNode::Kind::List || polygon->items.size() < 3) {
    in.complain(*polygon, "expected three corners or more: [[x, y], [x, y], [x, y]]");
    return std::nullopt;
  }
  MarkedRegion region;
  for (const YamlNode& corner : polygon->items) {
    const auto p = in.numbers(corner, 2, "[x, y]");
    if (!p) return std::nullopt;
    region.corners.push_back({(*p)[0], (*p)[1]});
  }
  if (const auto sides = crossing_sides(region.corners)) {
    const auto side = [&](size_t i) {
      const Vec2d &a = region.corners[i], &b = region.corners[(i + 1) % region.corners.size()];
      return fmt::format("({:g}, {:g}) to ({:g}, {:g})", a.x, a.y, b.x, b.y);
    };
    in.complain(polygon->items[sides->second], fmt::format("the outline crosses itself: its side from {} meets that from {}",
                                                           side(sides->second), side(sides->first)));
    return std::nullopt;
  }
  if (area(region.corners) == 0) {
    in.complain(*polygon, "the outline encloses nothing: its corners lie on one line");
    return std::nullopt;
  }
  return region;
}

const YamlNode& corner_node(const YamlNode& mark, size_t corner) {
  const YamlNode* polygon = mark.find("polygon");
  if (polygon != nullptr && corner < polygon->items.size()) return polygon->items[corner];
  const YamlNode* box = mark.find("box");
  return box != nullptr ? *box : mark;
}

}  // namespace vitrine
