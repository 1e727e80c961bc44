// Text helpers for configuration: edit distance for "did you mean", single-line lists, quoting, wrapping.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/config/describe.h"

namespace vitrine {

// Damerau-Levenshtein distance (optimal string alignment), case-insensitive.
size_t edit_distance(std::string_view a, std::string_view b);
// Nearest word within an edit distance of about a third of the length; ties: the first. A match with the last part of a dotted
// path counts as near ("voxel" -> "fusion.voxel"). Empty if nothing is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);
// "[a, b]" or "a,b" -> {"a","b"}; "" and "[]" -> {}. Double quotes protect commas.
std::vector<std::string> split_list(std::string_view text);
// Unquoted if YAML reads the text as the same plain string, else in double quotes with escapes.
std::string quoted_if_needed(std::string_view text);
std::string in_quotes(std::string_view text);
// Value as used in the cache key: strings always quoted, so that no value can imitate another line.
std::string canonical_value(const Option& option);
// Wraps words to at most `width` columns.
std::vector<std::string> wrapped(std::string_view text, size_t width);
// ".YML" -> ".yml"
std::string lower_extension(const std::filesystem::path& path);

}  // namespace vitrine
