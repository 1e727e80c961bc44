#include "stages/sfm/work_folder.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/foundation/base/error.h"

namespace vitrine {

std::optional<std::string> cannot_map_files(const fs::path& folder) {
  constexpr size_t kBytes = 4096;
  make_folders(folder);
  const fs::path probe = folder / "mmap_probe";
  const int file = open(probe.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0 || ftruncate(file, kBytes) != 0) {
    const int cause = errno;
    if (file >= 0) close(file);
    throw_write_error(probe, cause);
  }
  void* mapped = mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  const int cause = errno;
  if (mapped != MAP_FAILED) munmap(mapped, kBytes);
  close(file);
  std::error_code ignored;
  fs::remove(probe, ignored);
  return mapped == MAP_FAILED ? std::optional<std::string>(std::strerror(cause)) : std::nullopt;
}

WorkFolder::WorkFolder(const fs::path& scratch, const std::function<void(const char* code, const std::string& text)>& warn)
    : scratch_(scratch) {
  const auto reason = cannot_map_files(scratch_);
  if (!reason) return;
  local_.emplace("vitrine-sfm");
  const fs::path temporary = local_->path().parent_path();
  if (const auto also = cannot_map_files(local_->path()))
    throw Error(
        ErrorKind::Resource, "COLMAP's database has no place",
        {.where = scratch_.string(),
         .why = fmt::format("its file system cannot map files into shared memory ({}), as the database needs; nor can that "
                            "of {} ({})",
                            *reason, temporary.string(), *also),
         .hint = "put the output folder (-o) on a local disk, or set TMPDIR to a folder there",
         .code = "NO_MMAP"});
  warn("SCRATCH_ELSEWHERE",
       fmt::format(
           "the file system of the output folder cannot map files into shared memory ({}), as COLMAP's database needs: the "
           "database is kept in {} until sfm is done",
           *reason, temporary.string()));
}

WorkFolder::~WorkFolder() {
  if (!local_) return;
  // Error messages name the log in the scratch folder.
  std::error_code ignored;
  fs::create_directories(scratch_ / "colmap", ignored);
  fs::copy_file(path() / "colmap.log", scratch_ / "colmap" / "colmap.log", fs::copy_options::overwrite_existing, ignored);
}

}  // namespace vitrine
