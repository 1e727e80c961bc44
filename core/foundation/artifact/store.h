// Content-addressed store: <root>/<stage>/<key>/ holds the files of one artifact, manifest.json and timing.json. Artifacts appear
// atomically: files are written to <key>.tmp-<pid>/ and synced, the manifest is written last, then the folder is renamed.
// Leftovers of a killed process have another name; the next process removes them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/artifact/digest_cache.h"
#include "core/foundation/artifact/manifest.h"
#include "core/foundation/base/file.h"

namespace vitrine {

inline constexpr std::string_view kManifestName = "manifest.json";
inline constexpr std::string_view kTimingName = "timing.json";

class ArtifactStore {
 public:
  explicit ArtifactStore(fs::path root);

  const fs::path& root() const { return root_; }
  fs::path entry(std::string_view stage, std::string_view key) const { return root_ / stage / key; }
  fs::path scratch(std::string_view stage, std::string_view key) const { return root_ / stage / (std::string(key) + ".scratch"); }
  DigestCache& digests() { return digests_; }

  // The committed artifact, or nullopt; its files are not checked. Throws Error{Input} if the manifest cannot be read.
  std::optional<Manifest> find(std::string_view stage, std::string_view key) const;
  // Describes the damage of a committed artifact; empty when every file has the committed bytes.
  std::string damage(const fs::path& entry);
  void remove(std::string_view stage, std::string_view key) const;
  // Removes the temporary folders of dead processes for one stage. Returns the number of folders removed.
  int sweep(std::string_view stage) const;

  struct Entry {
    std::string stage, key;
    fs::path path;
    size_t bytes = 0;
    bool committed = false;  // false: scratch folders and leftovers
  };
  std::vector<Entry> entries() const;  // sorted by stage and key

 private:
  fs::path root_;
  DigestCache digests_;
};

// A folder being written. The destructor removes it unless it was committed.
class PendingArtifact {
 public:
  PendingArtifact(ArtifactStore& store, std::string_view stage, std::string_view key);
  ~PendingArtifact();
  PendingArtifact(const PendingArtifact&) = delete;
  PendingArtifact& operator=(const PendingArtifact&) = delete;

  const fs::path& path() const { return path_; }
  // Fills in outputs and content digest, syncs and renames; replaces an older entry of the same key. Returns the final folder.
  fs::path commit(Manifest& manifest, std::string_view timing_json);

 private:
  ArtifactStore& store_;
  std::string stage_, key_;
  fs::path path_;
  bool committed_ = false;
};

// Digest and size of every file of an artifact folder, without manifest and timing.
std::vector<OutputFile> artifact_files(DigestCache& digests, const fs::path& folder);

}  // namespace vitrine
