// Image regions with separate scores: glass (transparent), mirrors and glossy surfaces (specular), specular without glass
// (reflective), the object, and the rest = neither transparent nor specular, which is the region to compare opaque methods on. If
// the truth has coats, reflective is divided into clear coats over paint (coated), and metal and mirrors (mirror).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/render/picture/part_labels.h"
#include "core/scene/image/metrics.h"
#include "core/scene/objects/object_labels.h"
#include "stages/evaluate/truth.h"

namespace vitrine {

// Region name -> one channel of 0 and 1 at render size. Absent: the view has no mask of that class. `rest` requires the
// transparent or the specular mask, `reflective` the specular one, `coated` requires `coated`, and `mirror` both `coated` and the
// specular mask.
using RegionMasks = std::map<std::string, ImageF>;
const ImageF* mask_of(const RegionMasks& masks, const char* region);  // nullptr: absent

// Provider of region masks: from the truth's masks if it has any, else from the stages masks and objects.
class RegionSource {
 public:
  // `truth`: or nullptr; it and `objects` must outlive this.
  RegionSource(const Truth* truth, const std::optional<std::filesystem::path>& masks, const LabelledObjects& objects)
      : truth_(truth != nullptr && truth->has_maps("mask") ? truth : nullptr), masks_(masks), objects_(objects) {}
  // "truth", "objects", or empty: none.
  const char* from() const { return truth_ != nullptr ? "truth" : masks_ || !objects_.objects().empty() ? "objects" : ""; }
  // Masks of the view with that index, at render size.
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
  LocalCorrelation correlation;  // empty outside held-out views
};
// Errors of each region with at least `min_pixels` pixels, over its pixels and channels.
using RegionErrors = std::map<std::string, RegionError>;
RegionErrors region_errors(const RegionMasks& masks, const ImageF& srgb, const ImageF& photo_srgb, int min_pixels, bool heldout);
// nullopt: fewer than `min_pixels` pixels.
std::optional<RegionError> region_error(const ImageF& mask, const ImageF& srgb, const ImageF& photo_srgb, int min_pixels,
                                        bool heldout);

// Consistency of the surfels' object ids with the label images of held-out photos, which were not used to assign the ids.

class ObjectAgreement {
 public:
  // All must outlive it. `near_z`: of the rasteriser.
  ObjectAgreement(const SplatLayer& diffuse, float near_z, const ObjectSet& objects)
      : diffuse_(diffuse), near_z_(near_z), objects_(objects) {}
  void add(LabelledView photo);

  // IoU of each object between rendered_objects() and the labels, over all added photos.
  std::map<uint16_t, double> iou() const;
  // Share of the surfels visible in these photos whose id is the label of most of their pixels; nullopt without a photo or an id.
  // Surfels without id seen through thin glass are excluded.
  std::optional<double> surfel_accuracy() const;

 private:
  struct Pixels {
    size_t both = 0, either = 0;
  };
  const SplatLayer& diffuse_;
  float near_z_;
  const ObjectSet& objects_;
  std::vector<LabelledView> photos_;
  std::map<uint16_t, Pixels> pixels_;
};

}  // namespace vitrine
