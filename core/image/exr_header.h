// The headers of an OpenEXR file, before the library is given them: it allocates what a size says before it looks whether the
// file has it, and some types it reads by their contents, after which it is elsewhere than the size says.
#pragma once

#include <filesystem>

namespace vitrine {

// Whether every attribute (name, type, size, bytes; an empty name ends them) lies in the file and has the size of its type.
bool whole_exr_header(const std::filesystem::path& path);

}  // namespace vitrine
