// The files below a folder as people and their systems leave it: links to folders are followed, never in a circle; what operating
// systems, cameras and network drives put beside files is left out and counted. Photos, masks and content digests are found by
// this one function, so that what a stage reads and what its key is made of are the same files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace vitrine {

// A file or folder that is reached twice (by its name and by a link, or by two links).
enum class ReachedTwice {
  Once,   // counts once: under its own name, else (a folder) under that of the first link
  Always  // counts under each name: a link `specular -> transparent` means both
};

struct FolderFiles {
  std::vector<std::filesystem::path> files;  // regular files, relative to the folder, sorted by bytes
  size_t hidden = 0;                         // files and folders whose name starts with a dot
  size_t junk = 0;                           // files and folders that is_system_junk() names
  // Relative to the folder, sorted.
  std::vector<std::string> dangling;    // links to nothing
  std::vector<std::string> circles;     // links to a folder that they lie in
  std::vector<std::string> repeated;    // links to what is there already (ReachedTwice::Once)
  std::vector<std::string> unreadable;  // folders that cannot be opened
};

// `error` is set when `folder` itself cannot be read.
FolderFiles files_below(const std::filesystem::path& folder, ReachedTwice twice, std::error_code& error);

// A file or folder that no person made: thumbnails and waste bins of network drives (@eaDir, #recycle), of Windows (Thumbs.db),
// macOS (__MACOSX), Linux (lost+found). Names that start with a dot are hidden anyway.
bool is_system_junk(std::string_view name);

}  // namespace vitrine
