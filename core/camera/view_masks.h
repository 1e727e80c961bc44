// The masks of calibrated views as the masks stage leaves them: masks/<class>/<stem>.png, as large as the undistorted photo,
// grey, white = belongs to the class. Masks of the user's own, under any name and size: mask_files.h.
#pragma once

#include <filesystem>
#include <optional>

#include "core/camera/mask_files.h"
#include "core/camera/view.h"

namespace vitrine {

// `artifact`: the folder that holds masks/.
std::filesystem::path view_mask_path(const std::filesystem::path& artifact, MaskClass kind, const View& view);

// One channel in [0, 1] of the size of the view, which is that of its photo; nullopt: the class has none of this photo.
// Throws Error{Input}: unreadable, or of another size.
std::optional<ImageF> read_view_mask(const std::filesystem::path& artifact, MaskClass kind, const View& view);

}  // namespace vitrine
