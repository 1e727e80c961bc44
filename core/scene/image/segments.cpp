#include "core/scene/image/segments.h"

#include "core/scene/image/tiff_directory.h"
#include "core/scene/image/tiff_pages.h"

namespace vitrine {

uint64_t number_at(std::string_view b, size_t at, size_t n, bool big_endian) {
  if (at > b.size() || b.size() - at < n) return 0;
  uint64_t v = 0;
  for (size_t i = 0; i < n; ++i) v = v << 8 | static_cast<unsigned char>(b[at + (big_endian ? i : n - 1 - i)]);
  return v;
}

size_t jpeg_segments(std::string_view b, const std::function<bool(unsigned marker, std::string_view payload)>& visit) {
  size_t at = 2;
  while (at + 4 <= b.size() && static_cast<unsigned char>(b[at]) == 0xff) {
    const unsigned marker = static_cast<unsigned char>(b[at + 1]);
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    if (marker == 0xda) return at + 2;
    if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8)) {  // no payload
      at += 2;
      continue;
    }
    const size_t length = number_at(b, at + 2, 2, true);
    if (length < 2) return 0;
    if (!visit(marker, b.substr(at + 4, length - 2))) return 0;
    at += 2 + length;
  }
  return 0;
}

bool is_start_of_frame(unsigned marker) {  // SOF0..15 without DHT, JPG, DAC
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

bool png_chunks(std::string_view b, const std::function<void(std::string_view type, std::string_view data)>& visit) {
  size_t at = 8;  // after the signature
  while (at + 12 <= b.size()) {
    const size_t length = number_at(b, at, 4, true);
    const std::string_view type = b.substr(at + 4, 4);
    if (type == "IEND") return true;
    if (visit) visit(type, b.substr(at + 8, length));
    at += 12 + length;
  }
  return false;
}

std::string_view tiff_profile(std::string_view b) {
  constexpr unsigned kIccProfile = 34675;
  const TiffPages pages = tiff_pages(b);
  const TiffBytes in(b, pages.big_endian);
  std::string_view profile;
  const auto look = [&](const TiffPage& page) {
    TiffDirectory(in, pages.big, page.directory).each([&](const TiffEntry& e) {
      if (e.tag == kIccProfile && e.size == 1 && profile.empty()) profile = in.text(e.values, e.count);
    });
  };
  if (!pages.pages.empty()) look(pages.chosen());
  for (const TiffPage& page : pages.pages) look(page);
  return profile;
}

std::string_view exr_attribute(std::string_view b, std::string_view name, std::string_view type) {
  size_t at = 8;  // after magic number and version
  const auto word = [&]() -> std::string_view {
    const size_t end = at < b.size() ? b.find('\0', at) : std::string_view::npos;
    if (end == std::string_view::npos) {
      at = b.size();
      return {};
    }
    const std::string_view text = b.substr(at, end - at);
    at = end + 1;
    return text;
  };
  while (at < b.size()) {
    const std::string_view here = word();
    if (here.empty()) return {};
    const std::string_view its_type = word();
    const uint64_t size = number_at(b, at, 4, false);
    if (at + 4 > b.size() || size > b.size() - at - 4) return {};
    at += 4;
    if (here == name && its_type == type) return b.substr(at, size);
    at += size;
  }
  return {};
}

}  // namespace vitrine
