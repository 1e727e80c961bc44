// Files that came with photos: named in documents, or in the photos' folder. For *.cpp files only (json_file.h).
#pragma once

#include <filesystem>
#include <optional>

#include "core/foundation/config/json_file.h"
#include "core/intake/photos/photo_files.h"

namespace vitrine {

// Resolves a file named by a JSON file in `folder`: the path as written; else, for a path from another machine
// ("/home/me/set/masks/a.png", "C:\\set\\masks\\a.png"), its longest suffix below `folder` with at least one folder. nullopt: it
// does not exist. Throws for a file outside `folder`.
std::optional<std::filesystem::path> named_file(const std::filesystem::path& folder, const JsonAt& written);

// Masks, maps and other companions of the photos of a folder, by name and content; empty for folders without photos.
std::vector<BesidePhoto> companions_in(const std::filesystem::path& folder);

}  // namespace vitrine
