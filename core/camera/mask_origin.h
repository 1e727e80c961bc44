// How the masks of a class came about: masks/origin.json of the masks stage.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/camera/mask_files.h"
#include "core/camera/view.h"

namespace vitrine {

struct MaskOrigin {
  std::string source = "files";  // masks.<class>.source: "files", "boxes", "onnx", "proposed", "none"
  std::string trust = "given";   // a word of ObjectTrust (core/objects)
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
