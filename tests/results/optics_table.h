// The table of README.md for tests/results/optics.json ("vitrine-optics 1", written by `vitrine-optics --record`): by how much
// each arm of training differs from the first, per region, over generated scenes.
#pragma once

#include <filesystem>
#include <string>

namespace vitrine {

inline constexpr const char* kOpticsFile = "optics.json";

// Markdown. Error{Input} names the file and the entry that is missing.
std::string optics_table(const std::filesystem::path& file);

}  // namespace vitrine
