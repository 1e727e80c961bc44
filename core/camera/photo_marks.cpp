#include "core/camera/photo_marks.h"

#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/config/photo_name_finder.h"
#include "core/config/text.h"

namespace vitrine {

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
  return region;
}

}  // namespace vitrine
