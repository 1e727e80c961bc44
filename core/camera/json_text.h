// Places in the text of a JSON document, and what people's mistakes in its syntax mean. For json_file.cpp.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace vitrine {

struct TextPlace {
  size_t line = 1, column = 1;
};
TextPlace place_in_text(std::string_view text, size_t byte);
// First byte of the value that a JSON pointer ("/frames/3/w") names; of the deepest value on its way that exists. `text` is a
// well-formed document; nullopt if it is not.
std::optional<size_t> place_of_value(std::string_view text, std::string_view pointer);
// What is wrong at `byte`, where the parser stopped: a trailing comma, a comment, NaN, ... `otherwise`: the parser's own words.
// May move `byte` to where the mistake begins.
std::string syntax_mistake(std::string_view text, size_t& byte, const std::string& otherwise);

}  // namespace vitrine
