#include "stages/evaluate/regions.h"

#include <algorithm>
#include <functional>

#include "core/scene/camera/view_masks.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr float kBelongs = 0.5f;

// 1 where `mask` is 1 and all `others` are 0.
ImageF without(const ImageF& mask, std::initializer_list<const ImageF*> others) {
  ImageF out = mask;
  for (const ImageF* other : others)
    if (other != nullptr)
      for (size_t i = 0; i < out.data().size(); ++i)
        if (other->data()[i] > 0) out.data()[i] = 0;
  return out;
}

// `of_class`, `coated`: 0 or 1 at render size.
RegionMasks region_masks(const std::function<std::optional<ImageF>(MaskClass)>& of_class, const std::optional<ImageF>& coated,
                         const Intrinsics& intrinsics) {
  RegionMasks masks;
  for (MaskClass c : kTruthClasses)
    if (auto mask = of_class(c)) masks.emplace(name(c), std::move(*mask));
  const ImageF *transparent = mask_of(masks, "transparent"), *specular = mask_of(masks, "specular");
  const ImageF* coat = coated ? &*coated : nullptr;
  if (transparent == nullptr && specular == nullptr && coat == nullptr) return masks;
  ImageF rest = without(ImageF(intrinsics.width, intrinsics.height, 1, 1.f), {transparent, specular, coat});
  if (specular != nullptr) masks.emplace("reflective", without(*specular, {transparent}));
  if (specular != nullptr && coat != nullptr) masks.emplace("mirror", without(*specular, {transparent, coat}));
  if (coat != nullptr) masks.emplace("coated", without(*coat, {transparent}));
  masks.emplace("rest", std::move(rest));
  return masks;
}

}  // namespace

const ImageF* mask_of(const RegionMasks& masks, const char* region) {
  const auto it = masks.find(region);
  return it == masks.end() ? nullptr : &it->second;
}

RegionMasks RegionSource::of(size_t index, const View& view, const Intrinsics& k) const {
  const auto mask = [&](MaskClass c) -> std::optional<ImageF> {
    if (truth_ != nullptr) return truth_->mask(index, c, k);
    const auto pixels = pixels_.of(c, view);
    return pixels ? std::optional(belonging(*pixels, k)) : std::nullopt;
  };
  auto coated = truth_ != nullptr ? truth_->coated(index, k) : std::nullopt;
  if (const auto coat = [](const Object& o) { return o.role == ObjectRole::Coat; }; truth_ == nullptr && objects_.any(coat))
    if (const ImageF pixels = objects_.coverage(view, view.intrinsics, coat); !pixels.empty()) coated = belonging(pixels, k);
  return region_masks(mask, coated, k);
}

ImageF belonging(const ImageF& coverage, const Intrinsics& intrinsics) {
  ImageF out = resized(coverage, intrinsics.width, intrinsics.height);
  for (float& v : out.data()) v = v >= kBelongs ? 1.f : 0.f;
  return out;
}

std::optional<ImageF> stage_mask(const std::filesystem::path& masks_folder, const View& view, MaskClass c,
                                 const Intrinsics& intrinsics) {
  const auto soft = read_view_mask(masks_folder, c, view);
  if (!soft) return std::nullopt;
  return belonging(*soft, intrinsics);
}

void keep_within(const ImageF& mask, ImageF& image) {
  const auto channels = size_t(image.channels());
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] *= mask.data()[i / channels];
}

std::optional<RegionError> region_error(const ImageF& mask, const ImageF& srgb, const ImageF& photo, int min_pixels,
                                        bool heldout) {
  if (std::ranges::count(mask.data(), 1.f) < min_pixels) return std::nullopt;
  return RegionError{squared_error(srgb, photo, &mask), heldout ? local_correlation(srgb, photo, &mask) : LocalCorrelation{}};
}

RegionErrors region_errors(const RegionMasks& masks, const ImageF& srgb, const ImageF& photo, int min_pixels, bool heldout) {
  RegionErrors errors;
  for (const auto& [region, mask] : masks)
    if (const auto error = region_error(mask, srgb, photo, min_pixels, heldout)) errors[region] = *error;
  return errors;
}

void ObjectAgreement::add(LabelledView photo) {
  if (diffuse_.object_ids().empty()) return;
  const Image16 ours = rendered_objects(diffuse_, near_z_, photo.view);
  for (size_t p = 0; p < ours.pixel_count(); ++p) {
    const uint16_t a = ours.data()[p], b = photo.labels.data()[p];
    if (a != 0) ++pixels_[a].either;
    if (b != 0 && b != a) ++pixels_[b].either;
    if (a != 0 && a == b) ++pixels_[a].both;
  }
  photos_.push_back(std::move(photo));
}

std::map<uint16_t, double> ObjectAgreement::iou() const {
  std::map<uint16_t, double> out;
  for (const auto& [id, p] : pixels_) out[id] = double(p.both) / double(p.either);
  return out;
}

std::optional<double> ObjectAgreement::surfel_accuracy() const {
  if (photos_.empty()) return std::nullopt;
  const SurfelLabels shown = labels_of_surfels(diffuse_, near_z_, photos_);
  size_t seen = 0, same = 0;
  for (size_t i = 0; i < shown.label.size(); ++i)
    if (const uint16_t id = diffuse_.object_ids()[i]; shown.seen[i] && (id != 0 || !shows_thin_glass(objects_, shown.label[i])))
      ++seen, same += shown.label[i] == id;
  return seen > 0 ? std::optional(double(same) / double(seen)) : std::nullopt;
}

}  // namespace vitrine
