// Well-formed UTF-8 (The Unicode Standard, table 3-7): overlong forms, halves of surrogate pairs and what lies beyond U+10FFFF
// are none.
#pragma once

#include <cstddef>
#include <string_view>

namespace vitrine {

// Length of the sequence at the beginning of `text`, which is not empty; 0 when there is no well-formed one.
size_t utf8_length(std::string_view text);

}  // namespace vitrine
