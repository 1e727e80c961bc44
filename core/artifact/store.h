// The content-addressed store: <root>/<stage>/<key>/ holds the files of one artifact, manifest.json and timing.json.
// An artifact appears whole or not at all: files are written into <key>.tmp-<pid>/, synced, the manifest is written last, the
// folder is renamed. Whatever a killed process leaves behind has another name and is swept away by the next one.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/artifact/digest_cache.h"
#include "core/artifact/manifest.h"
#include "core/base/file.h"

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

  // The committed artifact, without looking at its files. nullopt: there is none. A manifest that cannot be read is Error{Input}.
  std::optional<Manifest> find(std::string_view stage, std::string_view key) const;
  // What is wrong with the files of a committed artifact, in words; empty when every file has the bytes it was committed with.
  std::string damage(const fs::path& entry);
  void remove(std::string_view stage, std::string_view key) const;
  // Temporary folders of processes that no longer live, of one stage. Returns how many were removed.
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

// A folder being written. Vanishes with its contents unless committed.
class PendingArtifact {
 public:
  PendingArtifact(ArtifactStore& store, std::string_view stage, std::string_view key);
  ~PendingArtifact();
  PendingArtifact(const PendingArtifact&) = delete;
  PendingArtifact& operator=(const PendingArtifact&) = delete;

  const fs::path& path() const { return path_; }
  // Fills in outputs and content digest, syncs, renames; an older entry of the same key is replaced. Returns the final folder.
  fs::path commit(Manifest& manifest, std::string_view timing_json);

 private:
  ArtifactStore& store_;
  std::string stage_, key_;
  fs::path path_;
  bool committed_ = false;
};

// Digest and size of every file of an artifact folder (manifest and timing left out).
std::vector<OutputFile> artifact_files(DigestCache& digests, const fs::path& folder);

}  // namespace vitrine
