#include "core/image/exr_header.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <string>

namespace vitrine {

namespace fs = std::filesystem;

namespace {

// Bytes that the library reads for an attribute of this type, whatever the size beside it says.
size_t fixed_size(const std::string& type) {
  static const std::map<std::string, size_t> sizes = {{"box2f", 16},
                                                      {"box2i", 16},
                                                      {"chromaticities", 32},
                                                      {"compression", 1},
                                                      {"deepImageState", 1},
                                                      {"double", 8},
                                                      {"envmap", 1},
                                                      {"float", 4},
                                                      {"int", 4},
                                                      {"keycode", 28},
                                                      {"lineOrder", 1},
                                                      {"m33d", 72},
                                                      {"m33f", 36},
                                                      {"m44d", 128},
                                                      {"m44f", 64},
                                                      {"rational", 8},
                                                      {"tiledesc", 9},
                                                      {"timecode", 8},
                                                      {"v2d", 16},
                                                      {"v2f", 8},
                                                      {"v2i", 8},
                                                      {"v3d", 24},
                                                      {"v3f", 12},
                                                      {"v3i", 12}};
  const auto found = sizes.find(type);
  return found == sizes.end() ? 0 : found->second;
}

// Names with 16 bytes behind each, and an empty name at the very end.
bool whole_channel_list(const std::string& list) {
  for (size_t at = 0; at < list.size();) {
    const size_t end = list.find('\0', at);
    if (end == at) return at + 1 == list.size();
    if (end == std::string::npos || list.size() - end < 17) return false;
    at = end + 17;
  }
  return false;
}

bool whole_preview(const std::string& preview) {
  uint32_t size[2];
  if (preview.size() < sizeof size) return false;
  std::memcpy(size, preview.data(), sizeof size);
  return size[0] < 1 << 16 && size[1] < 1 << 16 && preview.size() == sizeof size + 4 * size_t(size[0]) * size[1];
}

}  // namespace

bool whole_exr_header(const fs::path& path) {
  constexpr size_t kLongestName = 256;
  std::ifstream in(path, std::ios::binary);
  const uint64_t size = fs::file_size(path);
  uint64_t at = 8;  // magic number and version
  in.seekg(5);
  const bool several_parts = in.get() & 0x10;  // an empty header ends them
  in.seekg(static_cast<std::streamoff>(at));
  const auto word = [&] {
    std::string text;
    for (int c = in.get(); c > 0 && text.size() < kLongestName; c = in.get()) text += static_cast<char>(c);
    at += text.size() + 1;
    return text;
  };
  while (in) {
    if (word().empty() && (!several_parts || word().empty())) return true;
    const std::string type = word();
    unsigned char raw[4] = {};
    in.read(reinterpret_cast<char*>(raw), 4);
    const uint64_t bytes = raw[0] | raw[1] << 8 | raw[2] << 16 | uint64_t(raw[3]) << 24;
    at += 4;
    bool whole = in && bytes <= size && at + bytes <= size;
    if (const size_t fixed = fixed_size(type); whole && fixed != 0) whole = bytes == fixed;
    if (whole && (type == "chlist" || type == "preview")) {
      std::string content(bytes, '\0');
      in.read(content.data(), static_cast<std::streamsize>(bytes));
      whole = in && (type == "chlist" ? whole_channel_list(content) : whole_preview(content));
    }
    if (!whole) return false;
    in.seekg(static_cast<std::streamoff>(at += bytes));
  }
  return true;
}

}  // namespace vitrine
