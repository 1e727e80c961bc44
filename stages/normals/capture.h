// What every source of normals looks at: cameras, sparse points, photos, and masks where there are any.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/camera/view_masks.h"
#include "core/camera/view_set.h"
#include "core/image/image.h"
#include "core/shape/shape_set.h"

namespace vitrine {

struct NormalCapture {
  std::filesystem::path sfm;
  std::optional<std::filesystem::path> masks;
  ViewSet set;
  ShapeSet shapes;                // of glass and metal; found before
  std::vector<uint32_t> helpers;  // photos that others may be matched with: not those kept for the evaluation

  // The photo, display-referred, at a size of the caller's. [h,w,3]
  ImageF photo(size_t view, int width, int height) const;
  // Mask of a class in [0,1] at that size; nullopt when the class has none of this photo.
  std::optional<ImageF> mask(MaskClass kind, size_t view, int width, int height) const;
};

NormalCapture load_normal_capture(const std::filesystem::path& sfm, const std::optional<std::filesystem::path>& masks,
                                  const std::optional<std::filesystem::path>& shapes, int holdout_every);

}  // namespace vitrine
