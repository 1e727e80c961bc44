#include "stages/edit/edit.h"

#include <fmt/format.h>

#include "core/foundation/config/chart.h"
#include "core/render/edit/selection_file.h"

namespace vitrine {

namespace {

constexpr double kMostTint = 10;
constexpr const char* kHint = "stages/edit/README.md shows the format";

class Reader {
 public:
  Reader(const std::filesystem::path& path, std::span<const View> views) : in_(read_yaml(path.string())), views_(views) {}

  std::vector<Edit> edits() {
    const YamlNode& root = in_.root();
    in_.only_keys(root, {"edits"});
    const YamlNode* list = root.find("edits");
    if (list == nullptr || list->kind != YamlNode::Kind::List || list->items.empty())
      in_.complain(list != nullptr ? *list : root, "edits must be a list of edits");
    else
      for (const YamlNode& node : list->items) edits_.push_back(edit(node));
    in_.finish(kHint);
    return std::move(edits_);
  }

 private:
  Edit edit(const YamlNode& node) {
    Edit out;
    out.name = fmt::format("edit {}", edits_.size() + 1);
    out.where = fmt::format("{}:{}:{}", in_.name(), node.mark.line, node.mark.column);
    in_.only_keys(node, {"name", "select", "set", "delete"});
    if (node.kind != YamlNode::Kind::Map) return out;
    if (const YamlNode* name = node.find("name")) {
      if (name->text.empty()) in_.complain(*name, "a name is a word or a sentence");
      out.name = name->text;
    }
    const YamlNode *select = node.find("select"), *set = node.find("set"), *remove = node.find("delete");
    if (select == nullptr) {
      in_.complain(node, "an edit needs 'select': a class, an object, a box, marks, a component, or 'all'");
    } else {
      out.select = read_selector(in_, *select, views_, out.wanted);
    }
    if ((set == nullptr) == (remove == nullptr)) {
      in_.complain(node, "an edit has either 'set' or 'delete: true'");
    } else if (remove != nullptr) {
      if (remove->text != "true") in_.complain(*remove, "it can only be 'delete: true'");
      out.remove = true;
    } else {
      out.set = change(*set);
    }
    return out;
  }

  MaterialChange change(const YamlNode& node) {
    MaterialChange out;
    in_.only_keys(node, {"tint", "f0", "roughness", "k_s", "tau", "scatter", "scatter_color", "brushed", "turned", "anisotropy"});
    if (node.kind != YamlNode::Kind::Map) return out;
    if (node.entries.empty()) in_.complain(node, "nothing is set: tint, f0, roughness, k_s, tau, scatter, brushed or turned");
    out.tint = color(node, "tint", kMostTint);
    out.f0 = color(node, "f0", 1);
    out.roughness = value(node, "roughness");
    out.specular_weight = value(node, "k_s");
    out.transmission = value(node, "tau");
    out.scatter = scatter(node);
    out.marks = brush_marks(node);
    return out;
  }

  std::optional<BrushMarks> brush_marks(const YamlNode& map) {
    const YamlNode *brushed = map.find("brushed"), *turned = map.find("turned"), *strength = map.find("anisotropy");
    if (brushed != nullptr && turned != nullptr) {
      in_.complain(*turned, "a metal is either 'brushed' or 'turned'");
      return std::nullopt;
    }
    const YamlNode* node = brushed != nullptr ? brushed : turned;
    if (node == nullptr) {
      if (strength != nullptr)
        in_.complain(*strength, "'anisotropy' needs the direction of the marks: 'brushed', or 'turned' and its axis");
      return std::nullopt;
    }
    const auto xyz = in_.numbers(*node, 3, "a direction [x, y, z] in the scene's frame");
    if (!xyz) return std::nullopt;
    const Vec3d direction{(*xyz)[0], (*xyz)[1], (*xyz)[2]};
    if (!(length(direction) > 0)) {
      in_.complain(*node, "[0, 0, 0] is no direction");
      return std::nullopt;
    }
    BrushMarks out{.direction = cast<float>(normalized(direction)), .turned = turned != nullptr};
    if (const auto given = value(map, "anisotropy")) out.anisotropy = *given;
    return out;
  }

  std::optional<Scatter> scatter(const YamlNode& map) {
    const YamlNode *length = map.find("scatter"), *tint = map.find("scatter_color");
    if (length == nullptr) {
      if (tint != nullptr) in_.complain(*tint, "'scatter_color' colours 'scatter', which is missing");
      return std::nullopt;
    }
    Scatter out;
    const auto parsed = length->kind == YamlNode::Kind::Scalar ? parse_length(length->text) : std::nullopt;
    if (!parsed) {
      in_.complain(*length,
                   "'scatter' is a length above 0: 4 mm, or a number in units of the scene; leave it out for a surface that "
                   "does not scatter light below it");
      return std::nullopt;
    }
    out.length = parsed->metres, out.metres = parsed->has_unit;
    if (tint == nullptr) return out;
    if (const auto rgb = color(map, "scatter_color", 1)) out.color = *rgb;
    if (!(out.color.x > 0 && out.color.y > 0 && out.color.z > 0))
      in_.complain(*tint, "each channel of 'scatter_color' must be above 0: it is a factor of the length");
    return out;
  }

  std::optional<float> value(const YamlNode& map, const char* key) {
    const YamlNode* node = map.find(key);
    if (node == nullptr) return std::nullopt;
    const auto v = in_.number(*node);
    return v && within(*node, key, *v, 1) ? std::optional(float(*v)) : std::nullopt;
  }
  std::optional<Vec3f> color(const YamlNode& map, const char* key, double most) {
    const YamlNode* node = map.find(key);
    if (node == nullptr) return std::nullopt;
    if (node->kind == YamlNode::Kind::Scalar) {
      const auto v = in_.number(*node);
      return v && within(*node, key, *v, most) ? std::optional(Vec3f{float(*v), float(*v), float(*v)}) : std::nullopt;
    }
    const auto rgb = in_.numbers(*node, 3, fmt::format("'{}' to be a number or [red, green, blue], linear", key));
    if (!rgb) return std::nullopt;
    for (double v : *rgb)
      if (!within(*node, key, v, most)) return std::nullopt;
    return Vec3f{float((*rgb)[0]), float((*rgb)[1]), float((*rgb)[2])};
  }
  bool within(const YamlNode& node, const char* key, double v, double most) {
    if (v >= 0 && v <= most) return true;
    in_.complain(node, fmt::format("'{}' must lie between 0 and {}, got {}", key, most, v));
    return false;
  }

  YamlReader in_;
  std::span<const View> views_;
  std::vector<Edit> edits_;
};

}  // namespace

std::vector<Edit> read_edits(const std::filesystem::path& path, std::span<const View> views) {
  return Reader(path, views).edits();
}

}  // namespace vitrine
