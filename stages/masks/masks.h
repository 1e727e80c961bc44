// Stage `masks`: pixels of the undistorted photos that belong to the object, to glass, to mirrors, or are ignored (README.md).
//   reads   sfm (cameras, undistorted photos); optionally masks or a segmentation network of the user
//   writes  masks/<class>/<stem>.png, masks/confidence/<stem>.png, masks/colmap/<name>.png, masks/report.json,
//           masks/contact_sheet.png; a class that is empty everywhere has no folder
#pragma once

#include "core/intake/masks/photo_masks.h"
#include "stages/masks/boxes/marked_source.h"
#include "stages/masks/mask_source.h"
#include "stages/masks/onnx/network_source.h"
#include "stages/masks/proposed/proposed_source.h"
#include "stages/stage.h"

namespace vitrine {

enum class MaskSourceKind { Auto, Files, Boxes, Onnx, Proposed, None };
enum class MaskFrame { Auto, Photo, Undistorted };  // what mask files were drawn on; Auto: found by their size

struct MaskClassConfig {
  MaskSourceKind source = MaskSourceKind::Auto;
  MaskPolarity polarity = MaskPolarity::Auto;
};
void describe(Describer& d, MaskClassConfig& c);

struct MasksConfig {
  MaskClassConfig object, transparent, specular, ignore;
  MaskClass flat = MaskClass::Object;
  MaskFrame frame = MaskFrame::Auto;
  int hull_voxels = kHullVoxels;  // no option: a test with small photos takes fewer
  NetworkMasksConfig onnx;
  ProposedConfig proposed;

  const MaskClassConfig& of(MaskClass kind) const;
};
void describe(Describer& d, MasksConfig& c);

void run_masks(const MasksConfig& config, StageContext& context);
Stage masks_stage();
StageCost masks_cost(const CostTerms& terms);

// What files are matched to: the photos, and instead of views that are cut from one photo that photo, unless a file is named
// after the view.
struct MaskedPhotos {
  MaskedPhotos(const MaskCapture& capture, const MaskFolder& folder, MaskClass kind);
  std::vector<std::string> names;
  std::vector<size_t> first_view;  // [photo]
  std::vector<size_t> of_view;     // [view] its photo
};

// Masks from the user's files: photo coordinates, resampled to the undistorted photos.

class FileSource final : public MaskSource {
 public:
  // Checks every file first: throws Error{Input} when no photo has a mask, when a mask has the wrong shape, or when masks look
  // inverted and no polarity was declared. `capture` must outlive the source.
  FileSource(const MaskCapture& capture, const MaskFolder& folder, MaskClass kind, const MaskClassConfig& config,
             MaskFrame frame);

  std::string_view name() const override { return "files"; }
  std::optional<SoftMask> at(size_t view) const override;
  void report(nlohmann::ordered_json& j) const override;
  size_t matched() const { return masks_.matched(); }
  const PhotoMasks& masks() const { return masks_; }
  const Notes& notes() const { return masks_.notes(); }

 private:
  const MaskCapture& capture_;
  MaskFrame frame_;
  MaskedPhotos photos_;
  PhotoMasks masks_;
};

}  // namespace vitrine
