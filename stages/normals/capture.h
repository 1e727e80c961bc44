// What every source of normals looks at: cameras, sparse points, photos, and objects where there are any.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/camera/view_set.h"
#include "core/image/image.h"
#include "core/objects/object_labels.h"

namespace vitrine {

struct NormalCapture {
  std::filesystem::path sfm;
  LabelledObjects objects;  // trusted ones
  ViewSet set;
  std::vector<uint32_t> helpers;  // photos that others may be matched with: not those kept for the evaluation

  // The photo, display-referred, at a size of the caller's. [h,w,3]
  ImageF photo(size_t view, int width, int height) const;
};

NormalCapture load_normal_capture(const std::filesystem::path& sfm, const std::optional<std::filesystem::path>& objects,
                                  int holdout_every);

}  // namespace vitrine
