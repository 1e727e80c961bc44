// Content digests of files, remembered by (device-independent) inode, size and modification time, so that a plan over gigabytes
// of unchanged photos reads nothing. Paths are not part of the entry: moving a folder, or hard-linking a file out of it, keeps
// them. A touched file is read again and gives the same digest. Only a cache: losing it costs time, never correctness.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>

#include "core/artifact/manifest.h"
#include "core/base/file.h"

namespace vitrine {

class DigestCache {
 public:
  explicit DigestCache(fs::path file) : file_(std::move(file)) {}  // nothing is read before the first question
  ~DigestCache();                                                  // saves, if there is anything new and the place is writable
  DigestCache(const DigestCache&) = delete;
  DigestCache& operator=(const DigestCache&) = delete;

  std::string digest(const fs::path& path);  // hex; Error{Input} when unreadable
  // A file, or every regular file below a folder (hidden ones left out, as photo folders collect .DS_Store and the like),
  // by relative name and content.
  std::string digest_tree(const fs::path& path);
  // All regular files below `folder`, sorted by relative path.
  std::vector<OutputFile> files_below(const fs::path& folder, bool hidden);

 private:
  using Stamp = std::tuple<uint64_t, uint64_t, int64_t>;  // inode, bytes, modification time in ns
  void load();
  fs::path file_;
  bool loaded_ = false, changed_ = false;
  std::map<Stamp, std::string> known_;
};

}  // namespace vitrine
