#include "core/image/segments.h"

#include <algorithm>
#include <vector>

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
  size_t at = 8;  // behind the signature
  while (at + 12 <= b.size()) {
    const size_t length = number_at(b, at, 4, true);
    const std::string_view type = b.substr(at + 4, 4);
    if (type == "IEND") return true;
    if (visit) visit(type, b.substr(at + 8, length));
    at += 12 + length;
  }
  return false;
}

std::string png_pixels(std::string_view b) {
  std::string out(b.substr(0, 8));
  size_t at = 8;
  while (at + 12 <= b.size()) {
    const size_t size = 12 + number_at(b, at, 4, true);
    const std::string_view type = b.substr(at + 4, 4);
    const bool critical = (type[0] & 0x20) == 0;
    if (critical || type == "tRNS") out += b.substr(at, size);
    at += size;
    if (type == "IEND") break;
  }
  return out;
}

namespace {

size_t tiff_type_size(unsigned type) {
  constexpr size_t sizes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  return type < std::size(sizes) ? sizes[type] : 0;
}

struct TiffLayout {
  bool big_endian = false;
  size_t count_size = 2, entry_size = 12, offset_size = 4;
  uint64_t first = 0;  // directory
};

std::optional<TiffLayout> tiff_layout(std::string_view b) {
  TiffLayout t;
  if (b.starts_with("MM"))
    t.big_endian = true;
  else if (!b.starts_with("II"))
    return std::nullopt;
  const uint64_t magic = number_at(b, 2, 2, t.big_endian);
  if (magic == 43) t.count_size = 8, t.entry_size = 20, t.offset_size = 8;
  if (magic != 42 && magic != 43) return std::nullopt;
  t.first = number_at(b, magic == 43 ? 8 : 4, t.offset_size, t.big_endian);
  return t;
}

std::optional<TiffField> field_of(std::string_view b, const TiffLayout& t, uint64_t directory, unsigned tag) {
  constexpr uint64_t kMostEntries = 4096;
  if (directory >= b.size()) return std::nullopt;
  const uint64_t entries = std::min(number_at(b, directory, t.count_size, t.big_endian), kMostEntries);
  for (uint64_t i = 0; i < entries; ++i) {
    const size_t at = directory + t.count_size + i * t.entry_size;
    if (at + t.entry_size > b.size()) return std::nullopt;
    if (number_at(b, at, 2, t.big_endian) != tag) continue;
    TiffField f{.type = static_cast<unsigned>(number_at(b, at + 2, 2, t.big_endian)),
                .count = number_at(b, at + 4, t.offset_size, t.big_endian),
                .bytes = {},
                .big_endian = t.big_endian};
    const size_t each = tiff_type_size(f.type), value = at + 4 + t.offset_size;
    if (each == 0 || f.count > b.size() / each) return std::nullopt;
    const size_t size = each * f.count;
    const uint64_t from = size <= t.offset_size ? value : number_at(b, value, t.offset_size, t.big_endian);
    if (from > b.size() || b.size() - from < size) return std::nullopt;
    f.bytes = b.substr(from, size);
    return f;
  }
  return std::nullopt;
}

}  // namespace

uint64_t TiffField::number(size_t index) const {
  const bool whole = type == 1 || type == 3 || type == 4 || type == 16;
  return whole && index < count ? number_at(bytes, index * tiff_type_size(type), tiff_type_size(type), big_endian) : 0;
}

std::optional<TiffField> tiff_field(std::string_view b, unsigned tag) {
  constexpr size_t kMostDirectories = 64;
  constexpr unsigned kWidth = 256, kHeight = 257, kSubDirectories = 330;
  const auto t = tiff_layout(b);
  if (!t) return std::nullopt;
  std::vector<uint64_t> directories;
  const auto add = [&](uint64_t at) {
    const bool is_new = at != 0 && at < b.size() && std::find(directories.begin(), directories.end(), at) == directories.end();
    if (is_new && directories.size() < kMostDirectories) directories.push_back(at);
    return is_new;
  };
  for (uint64_t at = t->first; add(at) && directories.size() < kMostDirectories;) {
    const uint64_t entries = number_at(b, at, t->count_size, t->big_endian);
    if (entries > b.size()) break;
    at = number_at(b, at + t->count_size + entries * t->entry_size, t->offset_size, t->big_endian);
  }
  for (size_t i = 0; i < directories.size(); ++i)
    if (const auto below = field_of(b, *t, directories[i], kSubDirectories)) {
      for (size_t k = 0; k < below->count && k < kMostDirectories; ++k)
        add(below->type == 13 ? number_at(below->bytes, 4 * k, 4, t->big_endian) : below->number(k));
    }
  const auto area = [&](uint64_t at) {
    const auto w = field_of(b, *t, at, kWidth), h = field_of(b, *t, at, kHeight);
    return w && h ? std::min<uint64_t>(w->number(), 1 << 20) * std::min<uint64_t>(h->number(), 1 << 20) : 0;
  };
  std::stable_sort(directories.begin(), directories.end(), [&](uint64_t a, uint64_t c) { return area(a) > area(c); });
  for (uint64_t at : directories)
    if (const auto field = field_of(b, *t, at, tag)) return field;
  return std::nullopt;
}

std::string_view exr_attribute(std::string_view b, std::string_view name, std::string_view type) {
  size_t at = 8;  // behind the magic number and the version
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
