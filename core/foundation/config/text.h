// Small text helpers of the configuration: edit distance for "did you mean", lists on one line, quoting, wrapping.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/config/describe.h"

namespace vitrine {

// Damerau-Levenshtein (optimal string alignment), letters compared without case.
size_t edit_distance(std::string_view a, std::string_view b);
// The word within about a third of the length; of equally near words the first. A word that equals the last part of a dotted
// path counts as near ("voxel" -> "fusion.voxel"). Empty when nothing is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);
// "[a, b]" or "a,b" -> {"a","b"}; "" and "[]" -> {}. Double quotes protect commas.
std::vector<std::string> split_list(std::string_view text);
// The text itself when a YAML reader would take it for the same plain string, else in double quotes with escapes.
std::string quoted_if_needed(std::string_view text);
std::string in_quotes(std::string_view text);
// The value as it stands in the cache key: strings always in quotes, so that no value can imitate another line.
std::string canonical_value(const Option& option);
// Words broken into lines of at most `width` columns.
std::vector<std::string> wrapped(std::string_view text, size_t width);
// ".YML" -> ".yml"
std::string lower_extension(const std::filesystem::path& path);

}  // namespace vitrine
