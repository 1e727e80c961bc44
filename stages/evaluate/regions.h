// Parts of a picture that are scored apart: glass (transparent), mirrors and gloss (specular), gloss without glass (reflective),
// the object, and the rest = in neither the transparent nor the specular class. An opaque method is judged on the rest. Where the
// truth knows coats, what is reflective is divided: clear coats over paint (coated), and metal and mirrors (mirror).
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "core/image/metrics.h"
#include "stages/evaluate/truth.h"

namespace vitrine {

// Region name -> one channel of 0 and 1 at render size. Absent: no mask of that class for this view; `rest` is there when the
// transparent or the specular mask is, `reflective` when the specular one is, `coated` when `coated` is given, `mirror` when that
// and the specular mask are.
using RegionMasks = std::map<std::string, ImageF>;
// The mask of a class for the view in question, 0 or 1 at render size.
using MaskOf = std::function<std::optional<ImageF>(MaskClass)>;
RegionMasks region_masks(const MaskOf& mask_of, const std::optional<ImageF>& coated, const Intrinsics& intrinsics);

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
