// Recursive file listing, path containment, and errors of the file system. The listing follows links to folders without cycles;
// skips and counts files created by operating systems, cameras and network drives. Photos, masks and content digests all use this
// function, so the files a stage reads are exactly those in its cache key.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/foundation/base/error.h"

namespace vitrine {

// Handling of a file or folder reached twice (by its name and by a link, or by two links).
enum class ReachedTwice {
  Once,   // listed once: under its own name, else (a folder) under that of the first link
  Always  // listed under each name: a link `specular -> transparent` counts as both
};

struct FolderFiles {
  std::vector<std::filesystem::path> files;  // regular files, relative to the folder, sorted by bytes
  size_t hidden = 0;                         // files and folders with a leading dot
  size_t junk = 0;                           // files and folders for which is_system_junk() is true
  // Relative to the folder, sorted.
  std::vector<std::string> dangling;    // broken links
  std::vector<std::string> circles;     // links to an ancestor folder
  std::vector<std::string> repeated;    // links to files or folders already listed (ReachedTwice::Once)
  std::vector<std::string> unreadable;  // folders that cannot be opened
};

// Sets `error` if `folder` itself cannot be read.
FolderFiles files_below(const std::filesystem::path& folder, ReachedTwice twice, std::error_code& error);

// True for system files: thumbnails and recycle bins of network drives (@eaDir, #recycle), Windows (Thumbs.db), macOS
// (__MACOSX), Linux (lost+found). Names with a leading dot are hidden anyway.
bool is_system_junk(std::string_view name);

// --- path containment: names from external files must not leave their folder, and results must not be written into their inputs.

// True for a relative path without ".." and without a zero byte (which would truncate the name). Does not check existence or
// links.
bool stays_below(const std::filesystem::path& name);

// True if the path is the folder or inside it, with links resolved. Neither has to exist; relative paths are relative to the
// current folder.
bool lies_in(const std::filesystem::path& path, const std::filesystem::path& folder);

// Throws Error{Input} if the current folder was deleted, which makes relative paths invalid.
inline void require_current_folder() {
  std::error_code ec;
  (void)std::filesystem::current_path(ec);
  if (ec)
    throw Error(ErrorKind::Input, "the current folder does not exist any more",
                {.why = ec.message(), .hint = "cd into another folder, and start again", .code = "NO_CURRENT_FOLDER"});
}

// Converts a file system exception into Error{Input}.
inline Error error_of_file_system(const std::filesystem::filesystem_error& e) {
  return Error(ErrorKind::Input, "a file or folder cannot be used",
               {.where = e.path1().string(),
                .why = e.code().message(),
                .hint = "check that it exists and its permissions",
                .code = "FILE_SYSTEM"});
}

}  // namespace vitrine
