#include "core/foundation/artifact/digest_cache.h"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <sstream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/hash.h"

namespace vitrine {

namespace {

// Two changes within one clock tick of the file system get the same time stamp: younger files are not cached.
constexpr int64_t kSettleNs = 100'000'000;

int64_t nanoseconds(const timespec& t) { return static_cast<int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec; }

int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

[[noreturn]] void throw_unreadable(const fs::path& folder, const std::error_code& ec) {
  throw Error(
      ErrorKind::Input, "cannot read a folder",
      {.where = folder.string(), .why = ec.message(), .hint = "check the path and its permissions", .code = "UNREADABLE"});
}

}  // namespace

void DigestCache::load() {
  if (loaded_) return;
  loaded_ = true;
  if (file_.empty() || !fs::exists(file_)) return;
  std::istringstream in(read_file(file_));
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    uint64_t inode = 0, bytes = 0;
    int64_t modified = 0, changed = 0;
    std::string digest;
    if (words >> inode >> bytes >> modified >> changed >> digest && digest.size() == 32)
      known_[{inode, bytes, modified, changed}] = digest;
  }
}

DigestCache::~DigestCache() {
  std::error_code ec;
  // A dry run must not create the store.
  if (!changed_ || file_.empty() || !fs::is_directory(file_.parent_path(), ec)) return;
  std::string text;
  for (const auto& [stamp, digest] : known_)
    text += fmt::format("{} {} {} {} {}\n", stamp.inode, stamp.bytes, stamp.modified_ns, stamp.changed_ns, digest);
  try {
    write_file(file_, text);
  } catch (const Error&) {
    // The store is read-only: the next run computes the digests again.
  }
}

std::string DigestCache::digest(const fs::path& path) {
  load();
  struct stat s {};
  if (stat(path.c_str(), &s) != 0)
    throw Error(ErrorKind::Input, "cannot read a file",
                {.where = path.string(), .why = "it does not exist", .hint = "check the path", .code = "UNREADABLE"});
  const Stamp stamp{s.st_ino, static_cast<uint64_t>(s.st_size), nanoseconds(s.st_mtim), nanoseconds(s.st_ctim)};
  if (const auto found = known_.find(stamp); found != known_.end()) return found->second;
  std::string digest = digest_file(path).hex();
  if (now_ns() - std::max(stamp.modified_ns, stamp.changed_ns) > kSettleNs) {
    known_[stamp] = digest;
    changed_ = true;
  }
  return digest;
}

std::vector<OutputFile> DigestCache::artifact_files(const fs::path& folder) {
  std::vector<OutputFile> files;
  std::error_code ec;
  fs::recursive_directory_iterator it(folder, ec), end;
  for (; !ec && it != end; it.increment(ec))
    if (it->is_regular_file()) files.push_back({it->path().lexically_relative(folder).generic_string(), it->file_size(), {}});
  if (ec) throw_unreadable(folder, ec);
  std::sort(files.begin(), files.end(), [](const OutputFile& a, const OutputFile& b) { return a.path < b.path; });
  for (OutputFile& file : files) file.digest = digest(folder / file.path);
  return files;
}

std::string DigestCache::digest_tree(const fs::path& path) {
  if (!fs::is_directory(path)) return digest(path);
  std::error_code ec;
  std::vector<OutputFile> files;
  for (const fs::path& name : files_below(path, ReachedTwice::Always, ec).files) {
    const fs::path file = path / name;
    std::error_code size_error;
    files.push_back({name.generic_string(), fs::file_size(file, size_error), digest(file)});
  }
  if (ec) throw_unreadable(path, ec);
  return content_digest_of(files);
}

}  // namespace vitrine
