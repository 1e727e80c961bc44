#include "stages/masks/file_source.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/process.h"
#include "core/image/resample.h"

namespace vitrine {

namespace {

enum class Shape { Photo, Undistorted, Turned, Wrong };

// Same picture at another size: sides in proportion, up to the rounding of one pixel of the smaller one.
bool same_shape(int w, int h, double other_w, double other_h) {
  const double scale = double(w) / other_w;
  return std::abs(h - scale * other_h) <= std::max(1.0, scale) + 0.5;
}

Shape shape_of(const ImageF& mask, const Undistortion& u, const std::string& frame) {
  const int w = mask.width(), h = mask.height();
  const double photo_w = double(u.source.width), photo_h = double(u.source.height);
  const bool exact_target = w == u.target.width && h == u.target.height;
  if (frame == "undistorted") return same_shape(w, h, u.target.width, u.target.height) ? Shape::Undistorted : Shape::Wrong;
  // A mask of exactly the undistorted size was made on the undistorted photo, unless both sizes are one.
  if (frame == "auto" && exact_target && !(w == int(u.source.width) && h == int(u.source.height))) return Shape::Undistorted;
  if (same_shape(w, h, photo_w, photo_h)) return Shape::Photo;
  return same_shape(w, h, photo_h, photo_w) ? Shape::Turned : Shape::Wrong;
}

void clamp(ImageF& image) {
  for (float& v : image.data()) v = std::clamp(v, 0.f, 1.f);
}

}  // namespace

FileSource::FileSource(const MaskCapture& capture, const MaskFolder& folder, MaskClass kind, const MaskClassConfig& config,
                       const std::string& frame)
    : capture_(capture), frame_(frame), black_belongs_(config.polarity == "black"), files_(capture.set.views.size()) {
  const std::string class_name(vitrine::name(kind));
  for (size_t v = 0; v < files_.size(); ++v) {
    files_[v] = folder.find(kind, capture.set.views[v].name);
    matched_ += files_[v].has_value();
  }
  if (matched_ == 0)
    throw Error(
        ErrorKind::Input, fmt::format("no photo has a mask of the class '{}'", class_name),
        {.where = folder.path().string(),
         .why = fmt::format("{} files there; none is called like a photo, for example {}", folder.file_count(kind),
                            capture.set.views.front().name),
         .hint = fmt::format("call them {}.png, or --set masks.{}.source=none", capture.set.views.front().name, class_name),
         .code = "MASKS_MATCH_NO_PHOTO"});
  std::vector<MaskExtent> extents(files_.size());
  parallel_for(files_.size(), 1, [&](size_t v) {
    if (!files_[v] || interrupt_signal() != 0) return;
    const ImageF mask = upright_mask(v);
    const Undistortion& u = capture_.undistortions[v];
    const Shape shape = shape_of(mask, u, frame_);
    if (shape == Shape::Turned || shape == Shape::Wrong)
      throw Error(ErrorKind::Input, "a mask has another shape than its photo",
                  {.where = files_[v]->path.string(),
                   .why = fmt::format("{} x {} pixels; the photo has {} x {}", mask.width(), mask.height(),
                                      frame_ == "undistorted" ? u.target.width : int(u.source.width),
                                      frame_ == "undistorted" ? u.target.height : int(u.source.height)),
                   .hint = shape == Shape::Turned ? "photos are turned upright by their EXIF orientation: turn the mask as well"
                                                  : "masks may have another size than the photo, but show the same frame",
                   .code = "MASK_WRONG_SIZE"});
    extents[v].add(mask);
  });
  throw_if_interrupted();
  for (const MaskExtent& e : extents) {
    if (e.masks == 0) continue;
    const double n = double(++extent_.masks);
    extent_.mean += (e.mean - extent_.mean) / n;
    extent_.border += (e.border - extent_.border) / n;
    extent_.centre += (e.centre - extent_.centre) / n;
    extent_.empty += e.empty;
  }
  if (extent_.empty == extent_.masks)
    throw Error(
        ErrorKind::Input, fmt::format("all masks of the class '{}' are {}", class_name, black_belongs_ ? "white" : "black"),
        {.where = folder.path().string(),
         .why = fmt::format("{} masks, and no pixel belongs to the class", extent_.masks),
         .hint = fmt::format("white means '{}' (--set masks.{}.polarity=black turns it round); without such pixels: --set "
                             "masks.{}.source=none",
                             class_name, class_name, class_name),
         .code = "MASKS_ALL_BLACK"});
  if (config.polarity == "auto" && looks_inverted(extent_))
    throw Error(ErrorKind::Input, fmt::format("the masks of the class '{}' look inverted", class_name),
                {.where = folder.path().string(),
                 .why = fmt::format("{:.0f} % of the pixels are white, {:.0f} % at the border, {:.0f} % in the middle",
                                    100 * extent_.mean, 100 * extent_.border, 100 * extent_.centre),
                 .hint = fmt::format("--set masks.{}.polarity=black if black means '{}', white if they are right as they are",
                                     class_name, class_name),
                 .code = "MASKS_INVERTED"});
}

ImageF FileSource::upright_mask(size_t view) const {
  ImageF mask = read_mask(*files_[view]);
  if (black_belongs_)
    for (float& v : mask.data()) v = 1 - v;
  return mask;
}

std::optional<SoftMask> FileSource::at(size_t view) const {
  if (!files_[view]) return std::nullopt;
  ImageF mask = upright_mask(view);
  const Undistortion& u = capture_.undistortions[view];
  if (shape_of(mask, u, frame_) == Shape::Undistorted) {
    mask = resized(mask, u.target.width, u.target.height);
  } else {
    mask = undistorted(resized(mask, int(u.source.width), int(u.source.height)), u);
  }
  clamp(mask);
  SoftMask soft{.value = std::move(mask), .confidence = ImageF(u.target.width, u.target.height, 1, 1.f)};
  return soft;
}

void FileSource::report(nlohmann::ordered_json& j) const {
  std::set<std::string> conventions;
  for (const auto& f : files_)
    if (f) conventions.insert(f->convention);
  j["polarity"] = black_belongs_ ? "black" : "white";
  j["naming"] = conventions;
  j["photos_with_mask"] = matched_;
  j["photos_without_mask"] = files_.size() - matched_;
}

}  // namespace vitrine
