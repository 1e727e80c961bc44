// The folder that a program was started in may be gone by then; relative paths mean nothing there.
#pragma once

#include <filesystem>
#include <system_error>

#include "core/foundation/base/error.h"

namespace vitrine {

// Throws Error{Input} when there is no current folder.
inline void require_current_folder() {
  std::error_code ec;
  (void)std::filesystem::current_path(ec);
  if (ec)
    throw Error(ErrorKind::Input, "the current folder does not exist any more",
                {.why = ec.message(), .hint = "cd into another folder, and start again", .code = "NO_CURRENT_FOLDER"});
}

// What the file system refused, as an error of the input.
inline Error error_of_file_system(const std::filesystem::filesystem_error& e) {
  return Error(ErrorKind::Input, "a file or folder cannot be used",
               {.where = e.path1().string(),
                .why = e.code().message(),
                .hint = "check that it exists and its permissions",
                .code = "FILE_SYSTEM"});
}

}  // namespace vitrine
