// Cameras for rendering: those of the photos, or a camera path. Used by `vitrine render` and `vitrine relight`.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

inline constexpr int kMaxPictureSide = 16384;

enum class ViewChoice { Heldout, Train, All, Path };
inline constexpr std::array<std::string_view, 4> kViewChoiceWords{"heldout", "train", "all", "path"};

struct PictureViewsDesc {
  ViewChoice which = ViewChoice::Heldout;
  std::filesystem::path sfm, optimize;             // artifacts
  std::optional<std::filesystem::path> path = {};  // for ViewChoice::Path: a transforms.json in the scene's frame
  int width = 0, height = 0;                       // 0: training size, or the size in the path
};
// Never empty. Photo cameras are sorted by name. Path cameras keep the order of the file, have gain 1, and are named
// frame_0000.png onwards. Throws Error{Input} when there are none, Error{Usage} when the path is missing.
std::vector<View> picture_views(const PictureViewsDesc& desc);

// The same camera at exactly this picture size: pixels stay square, the excess is cropped on two sides.
Intrinsics covering(const Intrinsics& intrinsics, int width, int height);

}  // namespace vitrine
