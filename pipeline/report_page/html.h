// Building blocks of the page as text. Everything that comes from a file or a person goes through escaped(): a photo may be
// called <script>.
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

// For text and for attribute values in double quotes. Bytes that are no UTF-8 and control characters become U+FFFD.
std::string escaped(std::string_view text);

}  // namespace vitrine
