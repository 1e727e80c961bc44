// Masks from the user's files: photo coordinates, resampled to the undistorted photos.
#pragma once

#include "stages/masks/mask_source.h"
#include "stages/masks/masks.h"

namespace vitrine {

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
  PhotoMasks masks_;
};

}  // namespace vitrine
