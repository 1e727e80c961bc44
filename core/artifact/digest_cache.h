// Content digests of files, remembered by (device-independent) inode, size, and the times of the last modification and of the
// last change of the inode, so that a plan over gigabytes of unchanged photos reads nothing. Programs set the modification time
// as they like (copies, archives, editors that keep it); the change time of the inode is the system's own. Paths are not part of
// the entry: moving a folder keeps them. A file that was touched or linked is read again and gives the same digest. Only a cache:
// losing it costs time, never correctness.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <string>

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
  // A file, or what files_below() (core/base/folder_files.h) finds in a folder, by relative name and content.
  std::string digest_tree(const fs::path& path);
  // All regular files below the folder of an artifact, hidden ones too, sorted by relative path.
  std::vector<OutputFile> artifact_files(const fs::path& folder);

 private:
  struct Stamp {
    uint64_t inode, bytes;
    int64_t modified_ns, changed_ns;  // the file's content as its writer says; the inode, as the system says
    auto operator<=>(const Stamp&) const = default;
  };
  void load();
  fs::path file_;
  bool loaded_ = false, changed_ = false;
  std::map<Stamp, std::string> known_;
};

}  // namespace vitrine
