#include "stages/masks/boxes/marks_file.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/config/photo_name_finder.h"
#include "core/intake/masks/marks_check.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

constexpr int kEdgeSteps = 16;  // samples per edge: undistortion makes a straight edge a curve

class Reader {
 public:
  Reader(const fs::path& path, const MaskCapture& capture) : capture_(capture), in_(read_yaml(path.string())) {}

  Marks marks() {
    if (const YamlNode* marks = mark_list(in_)) {
      const std::optional<Vec2d> size = mark_size(in_, in_.root());
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

  // Maps the outline from the marked photo to the undistorted one, edge by edge.
  std::optional<std::vector<Vec2d>> outline(const GivenMark& mark, size_t view) {
    const Undistortion& u = capture_.undistortions[view];
    const double width = double(u.source.width), height = double(u.source.height);
    if (!mark_fits(in_, mark, PhotoPixels{int(u.source.width), int(u.source.height)})) return std::nullopt;
    const std::vector<Vec2d>& points = mark.region.corners;
    const Vec2d& size = mark.size;
    std::vector<Vec2d> out;
    for (size_t i = 0; i < points.size(); ++i) {
      const Vec2d &a = points[i], &b = points[(i + 1) % points.size()];
      for (int step = 0; step < kEdgeSteps; ++step) {
        const Vec2d p = a + (double(step) / kEdgeSteps) * (b - a);
        const Vec2d q{p.x * width / size.x, p.y * height / size.y};
        const std::optional<Vec2d> straight = undistorted(q, u);
        if (!straight) {
          in_.complain(
              *mark.node,
              fmt::format("the lens distorts ({:.0f}, {:.0f}) too much to locate it: mark nearer to the middle", p.x, p.y));
          return std::nullopt;
        }
        out.push_back(*straight);
      }
    }
    return out;
  }

  void read_mark(const YamlNode& node, const std::optional<Vec2d>& common_size) {
    bool lost = false;
    std::optional<size_t> view;
    const auto given = given_mark(in_, node, common_size, [&](const YamlNode& photo) {
      lost = meant_photo_is_lost(photo.text);
      if (!lost) view = marked_view(in_, photo, capture_.set.views);
      return lost || view.has_value();
    });
    if (!given) return;
    const std::string object_name = given->object();
    auto it = std::find_if(objects_.begin(), objects_.end(), [&](const MarkedObject& t) { return t.name == object_name; });
    if (it == objects_.end()) it = objects_.insert(objects_.end(), {object_name, given->word, given->kind, {}});
    if (lost) return void(lost_.emplace_back(object_name, given->photo->text));
    const auto line = outline(*given, *view);
    if (!line) return;
    Mark mark{.view = *view, .box = given->region.box, .outline = *line};
    if (std::any_of(it->marks.begin(), it->marks.end(), [&](const Mark& m) { return m.view == *view; }))
      return complain_of_second_mark(in_, *given);
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
