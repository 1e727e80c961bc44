// Errors for a deleted current folder, which makes relative paths invalid.
#pragma once

#include <filesystem>
#include <system_error>

#include "core/foundation/base/error.h"

namespace vitrine {

// Throws Error{Input} if the current folder does not exist.
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
