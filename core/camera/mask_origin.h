// How the masks of a class came about: masks/origin.json of the masks stage.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/camera/mask_files.h"

namespace vitrine {

struct MaskOrigin {
  std::string source = "files";  // masks.<class>.source: "files", "boxes", "onnx", "proposed", "none"
  std::string trust = "given";   // a word of ObjectTrust (core/objects)
  bool propagated = false;       // from few marks or none: edges may be off by pixels
};

// `artifact`: the folder that holds masks/. Masks without the file are the user's own. Throws Error{Input}.
MaskOrigin mask_origin(const std::filesystem::path& artifact, MaskClass kind);
void write_mask_origins(const std::filesystem::path& artifact, const std::map<MaskClass, MaskOrigin>& origins);

}  // namespace vitrine
