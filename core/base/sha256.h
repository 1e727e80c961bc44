// SHA-256 (FIPS 180-4): the digest that people publish beside files for download, as `sha256sum` prints it. For cache keys see
// hash.h, which is far quicker.
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

std::string sha256_hex(std::string_view bytes);  // 64 lower-case hex digits

}  // namespace vitrine
