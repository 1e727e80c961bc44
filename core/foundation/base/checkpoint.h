// Checkpoint files of a long computation: its state behind a digest, so that a damaged file is reported and never used.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace vitrine {

void write_checkpoint(const std::filesystem::path& path, const std::string& state);
// nullopt: the file does not exist. Throws Error{Input} if it is damaged.
std::optional<std::string> read_checkpoint(const std::filesystem::path& path);

}  // namespace vitrine
