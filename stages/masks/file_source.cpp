#include "stages/masks/masks.h"

#include <algorithm>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

enum class Shape { Photo, Undistorted, Turned, Wrong };

Shape shape_of(const ImageF& mask, const Undistortion& u, MaskFrame frame) {
  const int w = mask.width(), h = mask.height();
  const double photo_w = double(u.source.width), photo_h = double(u.source.height);
  const bool exact_target = w == u.target.width && h == u.target.height;
  if (frame == MaskFrame::Undistorted)
    return same_shape(w, h, u.target.width, u.target.height) ? Shape::Undistorted : Shape::Wrong;
  // A mask of exactly the undistorted size was made on the undistorted photo, unless both sizes are one.
  if (frame == MaskFrame::Auto && exact_target && !(w == int(u.source.width) && h == int(u.source.height)))
    return Shape::Undistorted;
  if (same_shape(w, h, photo_w, photo_h)) return Shape::Photo;
  return same_shape(w, h, photo_h, photo_w) ? Shape::Turned : Shape::Wrong;
}

PhotoMasks checked(const MaskCapture& capture, const MaskedPhotos& photos, const MaskFolder& folder, MaskClass kind,
                   const MaskClassConfig& config, MaskFrame frame) {
  const std::string class_name(name(kind));
  return PhotoMasks({.folder = folder,
                     .kind = kind,
                     .photos = photos.names,
                     .polarity = config.polarity,
                     .polarity_option = fmt::format("masks.{}.polarity", class_name),
                     .off_setting = fmt::format("masks.{}.source=none", class_name),
                     .usable = [&](size_t photo, const MaskFile& file, const ImageF& mask) {
                       const Undistortion& u = capture.undistortions[photos.first_view[photo]];
                       const Shape shape = shape_of(mask, u, frame);
                       const bool straight = frame == MaskFrame::Undistorted;
                       if (shape == Shape::Turned || shape == Shape::Wrong)
                         throw_wrong_mask_size(file, mask, straight ? u.target.width : int(u.source.width),
                                               straight ? u.target.height : int(u.source.height), shape == Shape::Turned);
                       return true;
                     }});
}

void clamp(ImageF& image) {
  for (float& v : image.data()) v = std::clamp(v, 0.f, 1.f);
}

}  // namespace

MaskedPhotos::MaskedPhotos(const MaskCapture& capture, const MaskFolder& folder, MaskClass kind) {
  std::map<std::string, size_t> index;
  for (size_t v = 0; v < capture.set.views.size(); ++v) {
    const std::string& view = capture.set.views[v].name;
    const bool of_photo = !capture.photos.empty() && capture.photos[v] != view && !folder.find(kind, view);
    const std::string& photo = of_photo ? capture.photos[v] : view;
    const auto [at, is_new] = index.try_emplace(photo, names.size());
    if (is_new) names.push_back(photo), first_view.push_back(v);
    of_view.push_back(at->second);
  }
}

FileSource::FileSource(const MaskCapture& capture, const MaskFolder& folder, MaskClass kind, const MaskClassConfig& config,
                       MaskFrame frame)
    : capture_(capture),
      frame_(frame),
      photos_(capture, folder, kind),
      masks_(checked(capture, photos_, folder, kind, config, frame)) {}

std::optional<SoftMask> FileSource::at(size_t view) const {
  if (!masks_.file(photos_.of_view[view])) return std::nullopt;
  ImageF mask = masks_.at(photos_.of_view[view]);
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
  j["polarity"] = masks_.black_belongs() ? "black" : "white";
  j["naming"] = masks_.conventions();
  j["photos_with_mask"] = masks_.matched();
  j["photos_without_mask"] = masks_.photo_count() - masks_.matched();
}

}  // namespace vitrine
