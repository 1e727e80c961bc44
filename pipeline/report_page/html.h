// HTML helpers. All text from files or users must pass through escaped(): a photo may be named <script>.
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

// Escapes text and attribute values in double quotes. Invalid UTF-8 and control characters become U+FFFD.
std::string escaped(std::string_view text);

}  // namespace vitrine
