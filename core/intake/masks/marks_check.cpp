#include "core/intake/masks/marks_check.h"

#include <map>
#include <set>

#include <fmt/format.h>

#include "core/intake/masks/mask_classes.h"
#include "core/intake/masks/photo_masks.h"

namespace vitrine {

namespace {

constexpr const char* kObjectKey = "thing";  // name of one of several objects of a class

// The photos of an object, and its first mark.
struct MarkedPhotos {
  const YamlNode* first = nullptr;
  std::set<std::string> photos;
};

}  // namespace

std::string GivenMark::object() const {
  std::string text(name(kind));
  return word.empty() ? text : text + " " + word;
}

const YamlNode* mark_list(YamlReader& in) {
  const YamlNode& root = in.root();
  if (root.kind != YamlNode::Kind::Null) in.only_keys(root, {"size", "marks"});
  if (root.kind == YamlNode::Kind::List || root.kind == YamlNode::Kind::Scalar) return nullptr;
  const YamlNode* marks = root.find("marks");
  if (marks != nullptr && marks->kind == YamlNode::Kind::List && !marks->items.empty()) return marks;
  in.complain(marks != nullptr ? *marks : root, "marks must be a list of marks");
  return nullptr;
}

std::optional<Vec2d> mark_size(YamlReader& in, const YamlNode& map) {
  const YamlNode* node = map.find("size");
  if (node == nullptr) return std::nullopt;
  const auto size = in.numbers(*node, 2, "[width, height] of the photo in pixels");
  if (!size) return std::nullopt;
  if ((*size)[0] > 0 && (*size)[1] > 0) return Vec2d{(*size)[0], (*size)[1]};
  in.complain(*node, "a photo has a positive width and height");
  return std::nullopt;
}

std::optional<GivenMark> given_mark(YamlReader& in, const YamlNode& entry, const std::optional<Vec2d>& common_size,
                                    const std::function<bool(const YamlNode& photo)>& find_photo) {
  const auto fail = [&](const YamlNode& at, const std::string& message) {
    in.complain(at, message);
    return std::nullopt;
  };
  in.only_keys(entry, {"photo", "class", "box", "polygon", "size", kObjectKey});
  if (entry.kind != YamlNode::Kind::Map) return std::nullopt;
  const YamlNode *photo = entry.find("photo"), *kind_node = entry.find("class"), *word = entry.find(kObjectKey);
  if (photo == nullptr || kind_node == nullptr) return fail(entry, "a mark names its photo and its class");
  if (word != nullptr && word->text.empty())
    return fail(*word, fmt::format("'{}' is the name of the object, not empty", kObjectKey));
  const bool known = find_photo(*photo);
  const std::optional<MaskClass> kind = mask_class(kind_node->text);
  if (!kind) {
    const auto meant = probable_mask_class(kind_node->text);
    in.complain(*kind_node, fmt::format("'{}' is no class: object, transparent, specular or ignore{}", kind_node->text,
                                        meant ? fmt::format("; did you mean '{}'?", name(*meant)) : ""));
  }
  const auto own_size = mark_size(in, entry);
  const auto region = marked_region(in, entry);
  if (!known || !kind || !region) return std::nullopt;
  const std::optional<Vec2d> size = own_size ? own_size : common_size;
  if (!size) return fail(entry, "of what size was the photo that was marked? size: [width, height], here or at the top");
  return GivenMark{&entry, photo, *kind, word != nullptr ? word->text : std::string(), *region, *size};
}

bool mark_fits(YamlReader& in, const GivenMark& mark, const std::optional<PhotoPixels>& photo) {
  const Vec2d& size = mark.size;
  if (photo && !same_shape(photo->width, photo->height, size.x, size.y)) {
    in.complain(*mark.node, fmt::format("a photo of {:.0f}x{:.0f} is not this one, which is {}x{}: is 'size' right?", size.x,
                                        size.y, photo->width, photo->height));
    return false;
  }
  for (size_t i = 0; i < mark.region.corners.size(); ++i) {
    const Vec2d& a = mark.region.corners[i];
    if (a.x >= 0 && a.y >= 0 && a.x <= size.x && a.y <= size.y) continue;
    in.complain(corner_node(*mark.node, i),
                fmt::format("({:.0f}, {:.0f}) lies outside a photo of {:.0f}x{:.0f}", a.x, a.y, size.x, size.y));
    return false;
  }
  return true;
}

void complain_of_second_mark(YamlReader& in, const GivenMark& mark) {
  in.complain(*mark.photo, fmt::format("'{}' is marked twice in this photo", mark.object()));
}

void check_marks(const std::filesystem::path& path, const MarkablePhotos& photos) {
  YamlReader in(read_yaml(path.string()));
  std::map<std::string, MarkedPhotos> marked;  // by the name of the object
  if (const YamlNode* marks = mark_list(in)) {
    const std::optional<Vec2d> size = mark_size(in, in.root());
    for (const YamlNode& entry : marks->items) {
      std::optional<size_t> photo;
      const auto mark = given_mark(in, entry, size, [&](const YamlNode& name) {
        if (!photos.names.empty()) photo = photos.find(name, in);
        return photos.names.empty() || photo.has_value();
      });
      if (!mark) continue;
      if (!mark_fits(in, *mark, photo ? photos.size(*photo) : std::nullopt)) continue;
      MarkedPhotos& object = marked[mark->object()];
      if (object.first == nullptr) object.first = &entry;
      if (!object.photos.insert(photo ? photos.names[*photo] : mark->photo->text).second) complain_of_second_mark(in, *mark);
    }
  }
  in.finish("stages/masks/README.md shows the format; vitrine mark shows and draws the marks");
  for (const auto& [name, object] : marked)
    if (object.photos.size() < 2)
      in.complain(*object.first,
                  fmt::format("'{}' is marked in one photo only; its position needs two from different sides", name));
  in.finish(fmt::format(
      "mark the same object in another photo, better in three (vitrine mark shows them); give each of several objects of a class "
      "a '{}', its name",
      kObjectKey));
}

}  // namespace vitrine
