// PNG files with an alpha channel, as background removers write them: the library writes none. Uncompressed (RFC 1950, 1951,
// 2083).
#pragma once

#include <cstdint>
#include <string>

#include "core/foundation/base/file.h"
#include "core/scene/image/image.h"

namespace vitrine::test {

inline std::string big_endian32(uint32_t v) { return {char(v >> 24), char(v >> 16 & 255), char(v >> 8 & 255), char(v & 255)}; }

inline std::string rgba_png_chunk(const std::string& typed) {
  uint32_t crc = 0xffffffffu;
  for (const char c : typed) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
  }
  return big_endian32(uint32_t(typed.size() - 4)) + typed + big_endian32(~crc);
}

inline void write_rgba_png(const std::filesystem::path& path, const Image8& image) {
  std::string rows;
  for (int y = 0; y < image.height(); ++y) {
    rows += '\0';  // no filter
    for (int x = 0; x < image.width(); ++x)
      for (int c = 0; c < 4; ++c) rows += char(image.at(x, y, c));
  }
  std::string stream = "\x78\x01";
  constexpr size_t kMost = 65535;  // bytes of a stored block
  for (size_t at = 0; at < rows.size(); at += kMost) {
    const size_t n = std::min(kMost, rows.size() - at);
    stream += at + n == rows.size() ? '\1' : '\0';
    for (const size_t v : {n, ~n}) stream += {char(v & 255), char(v >> 8 & 255)};
    stream += rows.substr(at, n);
  }
  uint32_t a = 1, b = 0;
  for (const char c : rows) a = (a + static_cast<unsigned char>(c)) % 65521, b = (b + a) % 65521;
  stream += big_endian32(b << 16 | a);
  const std::string size = big_endian32(uint32_t(image.width())) + big_endian32(uint32_t(image.height()));
  write_file(path, "\x89PNG\r\n\x1a\n" + rgba_png_chunk("IHDR" + size + std::string("\x08\x06\0\0\0", 5)) +
                       rgba_png_chunk("IDAT" + stream) + rgba_png_chunk("IEND"));
}

}  // namespace vitrine::test
