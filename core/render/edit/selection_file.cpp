#include "core/render/edit/selection_file.h"

#include <cmath>

#include <fmt/format.h>

#include "core/intake/masks/photo_marks.h"
#include "core/intake/masks/photo_masks.h"

namespace vitrine {

namespace {

std::optional<Bounds3> world_box(YamlReader& in, const YamlNode& node) {
  const auto b = in.numbers(node, 6, "[x0, y0, z0, x1, y1, z1] in the scene's frame");
  if (!b) return std::nullopt;
  const Bounds3 box{{(*b)[0], (*b)[1], (*b)[2]}, {(*b)[3], (*b)[4], (*b)[5]}};
  if (box.low.x < box.high.x && box.low.y < box.high.y && box.low.z < box.high.z) return box;
  in.complain(node, "x0 must be smaller than x1, y0 than y1, z0 than z1");
  return std::nullopt;
}

void add_mark(YamlReader& in, const YamlNode& node, std::span<const View> views, std::vector<EditMark>& marks) {
  in.only_keys(node, {"photo", "box", "polygon", "size"});
  if (node.kind != YamlNode::Kind::Map) return;
  const YamlNode* photo = node.find("photo");
  if (photo == nullptr) return in.complain(node, "a mark names its photo");
  const auto view = marked_view(in, *photo, views);
  auto region = marked_region(in, node);
  if (!view || !region) return;
  const Intrinsics& k = views[*view].intrinsics;
  Vec2d size{double(k.width), double(k.height)};
  if (const YamlNode* given = node.find("size")) {
    const auto s = in.numbers(*given, 2, "[width, height] of the photo in pixels");
    if (!s) return;
    size = {(*s)[0], (*s)[1]};
    if (!same_shape(k.width, k.height, size.x, size.y))
      return in.complain(*given, fmt::format("this photo has {}x{} pixels, or as many in proportion", k.width, k.height));
  }
  for (Vec2d& p : region->corners) {
    if (p.x < 0 || p.y < 0 || p.x > size.x || p.y > size.y)
      return in.complain(node, fmt::format("({}, {}) lies outside a photo of {}x{}", p.x, p.y, size.x, size.y));
    p = {p.x * k.width / size.x, p.y * k.height / size.y};
  }
  marks.push_back({*view, std::move(region->corners)});
}

Selector selector(YamlReader& in, const YamlNode& node, std::span<const View> views, bool outer, std::string& words) {
  Selector out;
  std::vector<std::string> keys{"class", "object", "box", "marks", "component"};
  if (outer) keys.emplace_back("except");
  in.only_keys(node, keys);
  if (node.kind != YamlNode::Kind::Map) return out;
  if (node.entries.empty()) in.complain(node, "it selects nothing; 'select: all' selects everything");
  const auto add = [&](const std::string& text) { words += (words.empty() ? "" : ", ") + text; };
  if (const YamlNode* kind = node.find("class")) {
    out.kind = mask_class(kind->text);
    if (!out.kind) in.complain(*kind, fmt::format("'{}' is no class: object, transparent, specular or ignore", kind->text));
    add(fmt::format("class {}", kind->text));
  }
  if (const YamlNode* object = node.find("object")) {
    if (object->kind != YamlNode::Kind::Scalar || object->text.empty())
      in.complain(*object, "an object is selected by its name in objects/objects.json");
    else
      out.object = object->text;
    add(fmt::format("object {}", object->text));
  }
  if (const YamlNode* box = node.find("box")) {
    out.box = world_box(in, *box);
    if (out.box)
      add(fmt::format("box [{}, {}, {}] to [{}, {}, {}]", out.box->low.x, out.box->low.y, out.box->low.z, out.box->high.x,
                      out.box->high.y, out.box->high.z));
  }
  if (const YamlNode* marks = node.find("marks")) {
    if (marks->kind != YamlNode::Kind::List || marks->items.empty())
      in.complain(*marks, "marks must be a list of marks in photos");
    else
      for (const YamlNode& one : marks->items) add_mark(in, one, views, out.marks);
    add(fmt::format("{} {}", marks->items.size(), marks->items.size() == 1 ? "mark" : "marks"));
  }
  if (const YamlNode* component = node.find("component")) {
    const auto n = in.number(*component);
    if (n && !(*n >= 1 && *n <= 1e9 && *n == std::floor(*n)))
      in.complain(*component, "components are numbered from 1, the one with most faces");
    else if (n)
      out.component = size_t(*n);
    add(fmt::format("component {}", component->text));
  }
  if (const YamlNode* except = outer ? node.find("except") : nullptr) {
    std::string left_out;
    out.except.push_back(selector(in, *except, views, false, left_out));
    words += (words.empty() ? "all but " : " but not ") + left_out;
  }
  return out;
}

}  // namespace

Selector read_selector(YamlReader& in, const YamlNode& node, std::span<const View> views, std::string& words) {
  if (node.kind != YamlNode::Kind::Scalar) return selector(in, node, views, true, words);
  if (node.text != "all") in.complain(node, fmt::format("\"{}\" is no selection: 'all', or a map", node.text));
  words = "all";
  return {};
}

}  // namespace vitrine
