// The state of a training run in a file: its bytes behind a digest, so that a damaged file is reported and never used.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/optim/archive.h"

namespace vitrine {

void write_checkpoint_bytes(const std::filesystem::path& path, const std::string& state);
// nullopt: there is no such file. Throws Error{Input} when it is damaged.
std::optional<std::string> read_checkpoint_bytes(const std::filesystem::path& path);

// `Run` has save(ArchiveWriter&) and load(ArchiveReader&).
template <class Run>
void write_checkpoint(const std::filesystem::path& path, const Run& run) {
  ArchiveWriter archive;
  run.save(archive);
  write_checkpoint_bytes(path, archive.bytes());
}
template <class Run>
bool load_checkpoint(const std::filesystem::path& path, Run& run) {
  const std::optional<std::string> state = read_checkpoint_bytes(path);
  if (!state) return false;
  ArchiveReader archive(*state);
  run.load(archive);
  return true;
}

}  // namespace vitrine
