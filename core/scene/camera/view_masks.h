// The masks of calibrated views as the masks stage leaves them: masks/<class>/<stem>.png, as large as the undistorted photo,
// grey, white = belongs to the class. Masks of the user's own, under any name and size: mask_files.h.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

// `artifact`: the folder that holds masks/.
std::filesystem::path view_mask_path(const std::filesystem::path& artifact, MaskClass kind, const View& view);

// One channel in [0, 1] of the size of the view, which is that of its photo; nullopt: the class has none of this photo.
// Throws Error{Input}: unreadable, or of another size.
std::optional<ImageF> read_view_mask(const std::filesystem::path& artifact, MaskClass kind, const View& view);

// How the masks of a class came about: masks/origin.json of the masks stage.
struct MaskOrigin {
  std::string source = "files";  // masks.<class>.source: "files", "boxes", "onnx", "proposed", "none"
  std::string trust = "given";   // a word of ObjectTrust (core/scene/objects)
  bool propagated = false;       // from few marks or none: edges may be off by pixels
};

// `artifact`: the folder that holds masks/. Masks without the file are the user's own. Throws Error{Input}.
MaskOrigin mask_origin(const std::filesystem::path& artifact, MaskClass kind);
// `things`: what marks call the things of masks/marked.
void write_mask_origins(const std::filesystem::path& artifact, const std::map<MaskClass, MaskOrigin>& origins,
                        const std::vector<std::string>& things = {});

// Things that a user marked: masks/marked/<photo>.png, 16 bit, of any size, has 1 + the index of the thing that a pixel shows, 0:
// none. Their names; empty: the marks give none.
std::vector<std::string> marked_things(const std::filesystem::path& artifact);
std::filesystem::path marked_things_path(const std::filesystem::path& artifact, const View& view);

}  // namespace vitrine
