// Which cameras a scene is pictured from: those of its photos, or those of a path. Used by `vitrine render` and `vitrine
// relight`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/view.h"

namespace vitrine {

inline constexpr int kMaxPictureSide = 16384;

struct PictureViewsDesc {
  std::string which = "heldout";                   // heldout, train, all, path
  std::filesystem::path sfm, optimize;             // artifacts
  std::optional<std::filesystem::path> path = {};  // which = path: a transforms.json in the scene's frame
  int width = 0, height = 0;                       // 0: as trained, or as the path says
};
// Never empty. Those of photos are sorted by name; those of a path keep the order of its file, have gain 1, and are named
// frame_0000.png on. Throws Error{Input} when there are none, Error{Usage} when the path is missing.
std::vector<View> picture_views(const PictureViewsDesc& desc);

// The same camera with a picture of exactly this size: square pixels stay square, and what does not fit the new shape is cut off
// on two sides.
Intrinsics covering(const Intrinsics& intrinsics, int width, int height);

}  // namespace vitrine
