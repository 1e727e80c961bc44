#include "core/camera/photo_marks.h"

#include <filesystem>

#include <fmt/format.h>

#include "core/config/text.h"

namespace vitrine {

bool names_photo(const std::string& text, const std::filesystem::path& photo) {
  const bool plain = std::filesystem::path(photo).replace_extension() == text;
  return photo == text || photo.filename() == text || photo.stem() == text || plain;
}

std::optional<size_t> marked_view(YamlReader& in, const YamlNode& name, std::span<const View> views) {
  std::vector<std::string> names;
  std::vector<size_t> meant;  // called so without their folder or extension
  for (size_t v = 0; v < views.size(); ++v) {
    if (views[v].name == name.text) return v;
    if (names_photo(name.text, views[v].name)) meant.push_back(v);
    names.push_back(views[v].name);
  }
  if (meant.size() == 1) return meant[0];
  if (meant.size() > 1) {
    in.complain(name, fmt::format("'{}' may be {} or {}: write all of its name", name.text, names[meant[0]], names[meant[1]]));
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
