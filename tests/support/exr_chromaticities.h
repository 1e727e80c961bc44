// An EXR that names the primaries of its colours.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "core/foundation/base/file.h"
#include "core/scene/image/color_profile.h"

namespace vitrine::test {

// Puts the attribute into a file of at most 16 rows: one block, whose offset moves.
inline void add_chromaticities(const fs::path& exr, const Chromaticities& c) {
  std::string bytes = read_file(exr);
  std::string attribute("chromaticities\0chromaticities\0\x20\0\0\0", 34);
  for (double v : {c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x, c.blue_y, c.white_x, c.white_y}) {
    const float f = static_cast<float>(v);
    attribute.append(reinterpret_cast<const char*>(&f), 4);
  }
  size_t at = 8;  // attributes: name, type, size, bytes; an empty name ends them
  const auto skip_word = [&] { at = bytes.find('\0', at) + 1; };
  while (bytes[at] != '\0') {
    skip_word(), skip_word();
    uint32_t size = 0;
    std::copy_n(bytes.data() + at, 4, reinterpret_cast<char*>(&size));
    at += 4 + size;
  }
  uint64_t block = 0;
  std::copy_n(bytes.data() + at + 1, 8, reinterpret_cast<char*>(&block));
  block += attribute.size();
  std::copy_n(reinterpret_cast<const char*>(&block), 8, bytes.data() + at + 1);
  write_file(exr, bytes.substr(0, 8) + attribute + bytes.substr(8));
}

}  // namespace vitrine::test
