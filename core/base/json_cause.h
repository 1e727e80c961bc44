// What nlohmann's JSON says, without its "[json.exception.type_error.302]". For *.cpp files.
#pragma once

#include <string>
#include <string_view>

#include "core/base/json.h"

namespace vitrine {

inline std::string cause_of(const nlohmann::json::exception& error) {
  std::string_view text = error.what();
  if (const size_t end = text.find("] "); text.starts_with("[json.exception.") && end != std::string_view::npos)
    text.remove_prefix(end + 2);
  return std::string(text);
}

}  // namespace vitrine
