// Cache of file content digests. Key: inode number (without the device), size, modification time (mtime) and inode change time
// (ctime). Planning a run over gigabytes of unchanged photos reads no file. Programs can set mtime (copies, archives, editors);
// only the system sets ctime. Paths are not part of the key: moving a folder keeps the entries. A touched or newly linked file
// is read again and gets the same digest. Losing the cache affects speed only.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <string>

#include "core/foundation/artifact/manifest.h"
#include "core/foundation/base/file.h"

namespace vitrine {

class DigestCache {
 public:
  explicit DigestCache(fs::path file) : file_(std::move(file)) {}  // loads the file at the first query
  ~DigestCache();                                                  // saves new entries if the folder is writable
  DigestCache(const DigestCache&) = delete;
  DigestCache& operator=(const DigestCache&) = delete;

  std::string digest(const fs::path& path);  // hex; throws Error{Input} if unreadable
  // Digest of a file, or of the files that files_below() (core/foundation/base/folder_files.h) lists in a folder, by relative name and
  // content.
  std::string digest_tree(const fs::path& path);
  // All regular files of an artifact folder, including hidden ones, sorted by relative path.
  std::vector<OutputFile> artifact_files(const fs::path& folder);

 private:
  struct Stamp {
    uint64_t inode, bytes;
    int64_t modified_ns, changed_ns;  // mtime, ctime
    auto operator<=>(const Stamp&) const = default;
  };
  void load();
  fs::path file_;
  bool loaded_ = false, changed_ = false;
  std::map<Stamp, std::string> known_;
};

}  // namespace vitrine
