#include "stages/masks/boxes/marks_file.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/intake/masks/photo_marks.h"
#include "core/intake/masks/photo_masks.h"
#include "core/foundation/config/photo_name_finder.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

constexpr int kEdgeSteps = 16;  // samples per edge: undistortion makes a straight edge a curve

class Reader {
 public:
  Reader(const fs::path& path, const MaskCapture& capture) : capture_(capture), in_(read_yaml(path.string())) {}

  Marks marks() {
    const YamlNode& root = in_.root();
    in_.only_keys(root, {"size", "marks"});
    const YamlNode* marks = root.find("marks");
    if (marks == nullptr || marks->kind != YamlNode::Kind::List || marks->items.empty()) {
      in_.complain(marks != nullptr ? *marks : root, "marks must be a list of marks");
    } else {
      const std::optional<Vec2d> size = size_of(root);
      for (const YamlNode& mark : marks->items) read_mark(mark, size);
    }
    in_.finish("stages/masks/README.md shows the format");
    for (const MarkedObject& object : objects_)
      if (object.marks.size() < 2)
        in_.complain(fmt::format("'{}' is marked in {}{}; its position needs two from different sides", object.name,
                                 object.marks.empty() ? "no photo that has a camera" : "one photo only", lost_marks_of(object)));
    in_.finish(
        "mark the same object in another photo, better in three (vitrine mark shows them); give each of several objects of a "
        "class a 'thing', its name");
    std::vector<std::string> lost;
    for (const auto& [object, photo] : lost_)
      if (std::ranges::find(lost, photo) == lost.end()) lost.push_back(photo);
    return {std::move(objects_), std::move(lost)};
  }

 private:
  // True if the text names a photo without a pose.
  bool meant_photo_is_lost(const std::string& text) const {
    std::vector<std::string> names;
    for (const View& view : capture_.set.views) names.push_back(view.name);
    names.insert(names.end(), capture_.without_camera.begin(), capture_.without_camera.end());
    const PhotoMatch meant = PhotoNameFinder(names).match(text);
    return meant.photo && *meant.photo >= capture_.set.views.size();
  }

  std::string lost_marks_of(const MarkedObject& object) const {
    std::vector<std::string> photos;
    for (const auto& [of, photo] : lost_)
      if (of == object.name) photos.push_back(photo);
    return photos.empty() ? "" : fmt::format(" (sfm could not place {})", fmt::join(photos, ", "));
  }

  std::optional<Vec2d> size_of(const YamlNode& map) {
    const YamlNode* node = map.find("size");
    if (node == nullptr) return std::nullopt;
    const auto size = in_.numbers(*node, 2, "[width, height] of the photo in pixels");
    if (!size) return std::nullopt;
    if ((*size)[0] > 0 && (*size)[1] > 0) return Vec2d{(*size)[0], (*size)[1]};
    in_.complain(*node, "a photo has a positive width and height");
    return std::nullopt;
  }

  // Maps the outline from the marked photo to the undistorted one, edge by edge.
  std::optional<std::vector<Vec2d>> outline(const YamlNode& mark, const std::vector<Vec2d>& points, const Vec2d& size,
                                            size_t view) {
    const Undistortion& u = capture_.undistortions[view];
    const double width = double(u.source.width), height = double(u.source.height);
    if (!same_shape(int(u.source.width), int(u.source.height), size.x, size.y)) {
      in_.complain(mark, fmt::format("a photo of {:.0f}x{:.0f} is not this one, which is {:.0f}x{:.0f}: is 'size' right?", size.x,
                                     size.y, width, height));
      return std::nullopt;
    }
    std::vector<Vec2d> out;
    for (size_t i = 0; i < points.size(); ++i) {
      const Vec2d &a = points[i], &b = points[(i + 1) % points.size()];
      if (a.x < 0 || a.y < 0 || a.x > size.x || a.y > size.y) {
        in_.complain(corner_node(mark, i),
                     fmt::format("({:.0f}, {:.0f}) lies outside a photo of {:.0f}x{:.0f}", a.x, a.y, size.x, size.y));
        return std::nullopt;
      }
      for (int step = 0; step < kEdgeSteps; ++step) {
        const Vec2d p = a + (double(step) / kEdgeSteps) * (b - a);
        const Vec2d q{p.x * width / size.x, p.y * height / size.y};
        const std::optional<Vec2d> straight = undistorted(q, u);
        if (!straight) {
          in_.complain(
              mark, fmt::format("the lens distorts ({:.0f}, {:.0f}) too much to locate it: mark nearer to the middle", p.x, p.y));
          return std::nullopt;
        }
        out.push_back(*straight);
      }
    }
    return out;
  }

  void read_mark(const YamlNode& node, const std::optional<Vec2d>& common_size) {
    in_.only_keys(node, {"photo", "class", "box", "polygon", "size", "thing"});
    if (node.kind != YamlNode::Kind::Map) return;
    const YamlNode *photo = node.find("photo"), *kind_node = node.find("class"), *word = node.find("thing");
    if (photo == nullptr || kind_node == nullptr) return in_.complain(node, "a mark names its photo and its class");
    if (word != nullptr && word->text.empty()) return in_.complain(*word, "'thing' is the name of the object, not empty");
    const bool lost = meant_photo_is_lost(photo->text);
    const auto view = lost ? std::nullopt : marked_view(in_, *photo, capture_.set.views);
    const std::optional<MaskClass> kind = mask_class(kind_node->text);
    if (!kind)
      in_.complain(*kind_node, fmt::format("'{}' is no class: object, transparent, specular or ignore", kind_node->text));
    const auto own_size = size_of(node);
    const auto region = marked_region(in_, node);
    if ((!view && !lost) || !kind || !region) return;
    const std::optional<Vec2d> size = own_size ? own_size : common_size;
    if (!size) return in_.complain(node, "of what size was the photo that was marked? size: [width, height], here or at the top");
    std::string object_name(name(*kind));
    if (word != nullptr) object_name += " " + word->text;
    auto it = std::find_if(objects_.begin(), objects_.end(), [&](const MarkedObject& t) { return t.name == object_name; });
    if (it == objects_.end())
      it = objects_.insert(objects_.end(), {object_name, word != nullptr ? word->text : std::string(), *kind, {}});
    if (lost) return void(lost_.emplace_back(object_name, photo->text));
    const auto line = outline(node, region->corners, *size, *view);
    if (!line) return;
    Mark mark{.view = *view, .box = region->box, .outline = *line};
    if (std::any_of(it->marks.begin(), it->marks.end(), [&](const Mark& m) { return m.view == *view; }))
      return in_.complain(*photo, fmt::format("'{}' is marked twice in this photo", object_name));
    it->marks.push_back(std::move(mark));
  }

  const MaskCapture& capture_;
  YamlReader in_;
  std::vector<MarkedObject> objects_;
  std::vector<std::pair<std::string, std::string>> lost_;  // object, photo without camera
};

}  // namespace

Marks read_marks(const fs::path& path, const MaskCapture& capture) { return Reader(path, capture).marks(); }

}  // namespace vitrine
