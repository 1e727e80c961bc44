// Silhouettes of a class of masks, as the masks stage leaves them (core/camera/view_masks.h).
#pragma once

#include <filesystem>
#include <optional>

#include "core/camera/mask_files.h"
#include "core/stereo/silhouette.h"

namespace vitrine {

// Of one photo, `size` pixels large; nullopt: the class has no mask of it. Pixels of glass are unknown in the silhouettes of
// other classes: what they mark is seen through it.
std::optional<Silhouette> mask_silhouette(const std::filesystem::path& masks, MaskClass kind, const View& photo,
                                          const Intrinsics& size);

// Some pixel shows an object.
bool marks_something(const Silhouette& silhouette);

}  // namespace vitrine
