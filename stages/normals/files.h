// Normal maps of the user's, from whatever predicted them: PNG of 8 or 16 bit with rgb = (n + 1) / 2, or EXR. README.md lists the
// names under which they are found.
#pragma once

#include <filesystem>
#include <optional>

#include "stages/normals/normal_map.h"

namespace vitrine {

// `folder`/<stem>.exr and the like; nullopt when the photo has none.
std::optional<std::filesystem::path> find_normal_file(const std::filesystem::path& folder, const View& view);

// In the file's own frame, at its own size; known pixels have confidence 1, or that of <stem>_confidence.png beside it. Throws
// Error{Input} when it is no normal map, or not of the photo's shape.
NormalMap read_normal_file(const std::filesystem::path& file, const View& view);

}  // namespace vitrine
