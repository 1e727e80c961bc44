// The state of a training run in a file: its bytes behind a digest, so that a damaged file is reported and never used.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace vitrine {

void write_checkpoint(const std::filesystem::path& path, const std::string& state);
// nullopt: there is no such file. Throws Error{Input} when it is damaged.
std::optional<std::string> read_checkpoint(const std::filesystem::path& path);

}  // namespace vitrine
