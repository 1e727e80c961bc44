// Masks of calibrated views written by the masks stage: masks/<class>/<stem>.png, size of the undistorted photo, grey, white =
// in the class. For the user's own masks, with any name and size, see mask_files.h.
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

// `artifact`: folder that contains masks/.
std::filesystem::path view_mask_path(const std::filesystem::path& artifact, MaskClass kind, const View& view);

// One channel in [0, 1] at the size of the view; nullopt if the class has no mask of this photo. Throws Error{Input} if
// unreadable or of another size.
std::optional<ImageF> read_view_mask(const std::filesystem::path& artifact, MaskClass kind, const View& view);

// Origin of the masks of a class: masks/origin.json of the masks stage.
struct MaskOrigin {
  std::string source = "files";  // masks.<class>.source: "files", "boxes", "onnx", "proposed", "none"
  std::string trust = "given";   // name of an ObjectTrust value (core/scene/objects)
  bool propagated = false;       // propagated from few annotations or none: edges may be off by pixels
};

// `artifact`: folder that contains masks/. Without the file the masks are the user's own. Throws Error{Input}.
MaskOrigin mask_origin(const std::filesystem::path& artifact, MaskClass kind);
// `objects`: names of the annotated objects in masks/marked.
void write_mask_origins(const std::filesystem::path& artifact, const std::map<MaskClass, MaskOrigin>& origins,
                        const std::vector<std::string>& objects = {});

// Names of the objects annotated by the user; empty if the annotations have no names. masks/marked/<photo>.png, 16 bit, any
// size, contains 1 + the object index per pixel, 0 = none.
std::vector<std::string> marked_objects(const std::filesystem::path& artifact);
std::filesystem::path marked_objects_path(const std::filesystem::path& artifact, const View& view);

}  // namespace vitrine
