// Normals from the photos themselves: stereo gives depths where there is texture, planes fitted to them give normals; inside the
// labels of glass and mirrors, which stereo cannot match, the shapes of the objects do.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/camera/view_set.h"
#include "core/scene/image/image.h"
#include "core/scene/objects/object_labels.h"
#include "stages/normals/normal_map.h"

namespace vitrine {

// What every source of normals looks at: cameras, sparse points, photos, and objects where there are any.
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

struct GeometricDesc {
  const NormalCapture& capture;
  int max_side;                     // at which the photos are matched, pixels
  std::span<const uint32_t> views;  // photos that are wanted
  bool with_objects = true;
};

// One map per wanted photo, at most desc.max_side large; empty for a photo that no other one can be matched with:
// `alone` counts them.
std::vector<NormalMap> geometric_normals(const GeometricDesc& desc, const std::function<void(double)>& progress,
                                         size_t* alone = nullptr);

}  // namespace vitrine
