// Base64 encoding (RFC 4648, with padding).
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

std::string base64(std::string_view bytes);

}  // namespace vitrine
