// Parts of a picture that are scored apart: glass (transparent), mirrors and gloss (specular), gloss without glass (reflective),
// the object, and the rest = in neither the transparent nor the specular class. An opaque method is judged on the rest. Where the
// truth knows coats, what is reflective is divided: clear coats over paint (coated), and metal and mirrors (mirror).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/scene/image/metrics.h"
#include "core/scene/objects/object_labels.h"
#include "stages/evaluate/truth.h"

namespace vitrine {

// Region name -> one channel of 0 and 1 at render size. Absent: no mask of that class for this view; `rest` is there when the
// transparent or the specular mask is, `reflective` when the specular one is, `coated` when `coated` is given, `mirror` when that
// and the specular mask are.
using RegionMasks = std::map<std::string, ImageF>;
const ImageF* mask_of(const RegionMasks& masks, const char* region);  // nullptr: absent

// The regions of a capture's views: of the truth's masks where it has any, else of the stages masks and objects.
class RegionSource {
 public:
  // `truth`: or nullptr; it must outlive this, like `objects`.
  RegionSource(const Truth* truth, const std::optional<std::filesystem::path>& masks, const LabelledObjects& objects)
      : truth_(truth != nullptr && truth->has_maps("mask") ? truth : nullptr), masks_(masks), objects_(objects) {}
  // "truth", "objects", or empty: there are none.
  const char* from() const { return truth_ != nullptr ? "truth" : masks_ || !objects_.objects().empty() ? "objects" : ""; }
  // Of the view with that index, at render size.
  RegionMasks of(size_t index, const View& view, const Intrinsics& intrinsics) const;

 private:
  const Truth* truth_;
  std::optional<std::filesystem::path> masks_;
  const LabelledObjects& objects_;
  ClassPixels pixels_{masks_, objects_};
};

// 1 where at least half of a pixel's area, at render size, is covered.
ImageF belonging(const ImageF& coverage, const Intrinsics& intrinsics);
// A mask of the masks stage (masks/<class>/<stem>.png, undistorted like the render) at render size: 1 where at least half of a
// pixel's area belongs to the class.
std::optional<ImageF> stage_mask(const std::filesystem::path& masks_folder, const View& view, MaskClass c,
                                 const Intrinsics& intrinsics);

// Black where `mask` [h,w,1] is 0.
void keep_within(const ImageF& mask, ImageF& image);

struct RegionError {
  SquaredError squared;
  LocalCorrelation correlation;  // of held-out views; nothing in it of others
};
// Of each region with at least `min_pixels` pixels, over its pixels and channels.
using RegionErrors = std::map<std::string, RegionError>;
RegionErrors region_errors(const RegionMasks& masks, const ImageF& srgb, const ImageF& photo_srgb, int min_pixels, bool heldout);
// nullopt: fewer pixels than that.
std::optional<RegionError> region_error(const ImageF& mask, const ImageF& srgb, const ImageF& photo_srgb, int min_pixels,
                                        bool heldout);

}  // namespace vitrine
