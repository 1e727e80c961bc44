// Folder for COLMAP's database and other intermediate files. COLMAP opens its database in the WAL mode of SQLite, which maps a
// file into memory that two connections share (https://sqlite.org/wal.html): network and FUSE file systems often cannot. On such
// a scratch folder the files are kept in a temporary folder ($TMPDIR or /tmp), and COLMAP's log is copied back.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/foundation/base/file.h"

namespace vitrine {

// Reason why files in the folder cannot be mapped into shared memory; nullopt: they can. Throws Error{Resource} if no file can be
// written.
std::optional<std::string> cannot_map_files(const fs::path& folder);

class WorkFolder {
 public:
  // `warn(code, text)` is called if another folder than `scratch` is used. Throws Error{Resource, NO_MMAP} if no folder can be.
  WorkFolder(const fs::path& scratch, const std::function<void(const char* code, const std::string& text)>& warn);
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  fs::path path() const { return (local_ ? local_->path() : scratch_) / "colmap"; }

 private:
  fs::path scratch_;
  std::optional<TemporaryFolder> local_;
};

}  // namespace vitrine
