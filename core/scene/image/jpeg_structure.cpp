#include "core/scene/image/segments.h"

#include <algorithm>

#include <fmt/format.h>

namespace vitrine {

namespace {

unsigned jpeg_byte(std::string_view b, size_t at) { return static_cast<unsigned char>(b[at]); }

enum JpegMarker : unsigned {
  kStuffedZero = 0x00,
  kTemporary = 0x01,
  kStartOfFrame0 = 0xc0,
  kHuffmanTables = 0xc4,
  kExtensions = 0xc8,
  kArithmeticTables = 0xcc,
  kStartOfFrame15 = 0xcf,
  kRestart0 = 0xd0,
  kRestart7 = 0xd7,
  kStartOfImage = 0xd8,
  kEndOfImage = 0xd9,
  kStartOfScan = 0xda,
  kQuantization = 0xdb,
  kNumberOfLines = 0xdc,
  kRestartInterval = 0xdd,
  kApplication0 = 0xe0,
  kApplication15 = 0xef,
  kComment = 0xfe,
};

bool is_frame(unsigned marker) {
  return marker >= kStartOfFrame0 && marker <= kStartOfFrame15 && marker != kHuffmanTables && marker != kExtensions &&
         marker != kArithmeticTables;
}

// Markers allowed between the scans of an image.
bool continues_picture(unsigned m) {
  return m == kHuffmanTables || m == kArithmeticTables || (m >= kStartOfScan && m <= kRestartInterval) ||
         (m >= kApplication0 && m <= kApplication15) || m == kComment || m == kEndOfImage;
}

std::string refused_frame(unsigned marker, std::string_view payload) {
  constexpr const char* kExport = "export it as a usual JPEG (8 bit, RGB), or as 16-bit TIFF";
  switch (marker) {
    case 0xc3:
    case 0xcb:
      return fmt::format("it is a lossless JPEG, which is not read: {}", kExport);
    case 0xc5:
    case 0xc6:
    case 0xc7:
    case 0xcd:
    case 0xce:
    case 0xcf:
      return fmt::format("it is a hierarchical JPEG, which is not read: {}", kExport);
    default:
      break;
  }
  if (payload.size() < 6) return "";
  if (const unsigned bits = jpeg_byte(payload, 0); bits != 8)
    return fmt::format("it is a JPEG of {} bits per sample, which is not read: {}", bits, kExport);
  const unsigned components = jpeg_byte(payload, 5);
  if (components == 4) return fmt::format("it is a CMYK JPEG (densities of inks): {}", kExport);
  if (components != 1 && components != 3) return fmt::format("it is a JPEG of {} channels: {}", components, kExport);
  return "";
}

// Offset of the next marker after entropy-coded data, in which each ff is followed by 00 or a restart marker; npos if the bytes
// end before.
size_t end_of_scan(std::string_view b, size_t at) {
  for (;;) {
    at = b.find('\xff', at);
    if (at == std::string_view::npos || at + 1 >= b.size()) return std::string_view::npos;
    const unsigned next = jpeg_byte(b, at + 1);
    if (next == 0xff)
      ++at;  // fill byte
    else if (next == kStuffedZero || (next >= kRestart0 && next <= kRestart7))
      at += 2;
    else
      return at;
  }
}

}  // namespace

JpegStructure jpeg_structure(std::string_view b) {
  JpegStructure s;
  size_t at = 2, scans = 0;
  unsigned components = 0;
  bool frame = false, one_scan = false;
  const auto cut = [&] {
    s.damage = scans == 0 ? "the JPEG ends before its picture data: the file is truncated"
                          : "the JPEG ends before its end marker: the file is truncated";
    return s;
  };
  while (at + 2 <= b.size()) {
    if (jpeg_byte(b, at) != 0xff) {  // decoders skip bytes between segments
      at = b.find('\xff', at);
      if (at == std::string_view::npos) return cut();
      continue;
    }
    const unsigned marker = jpeg_byte(b, at + 1);
    if (marker == 0xff) {
      ++at;
      continue;
    }
    if (marker == kEndOfImage) {
      s.end = at + 2;
      if (scans == 0) s.damage = "the JPEG has no picture data: it is damaged";
      return s;
    }
    if (marker == kTemporary || (marker >= kRestart0 && marker <= kRestart7) || marker == kStuffedZero) {
      at += 2;
      continue;
    }
    if (marker == kStartOfImage || (scans > 0 && !continues_picture(marker))) {
      s.damage = fmt::format("the JPEG is damaged or cut short: ff {:02x} stands where its data should go on", marker);
      return s;
    }
    if (at + 4 > b.size()) return cut();
    const size_t length = jpeg_byte(b, at + 2) << 8 | jpeg_byte(b, at + 3);
    if (length < 2) {
      s.damage = "the JPEG has a segment without a length: it is damaged";
      return s;
    }
    if (length > b.size() - at - 2) return cut();
    if (is_frame(marker) && !frame) {
      frame = true;
      if (length >= 8) components = jpeg_byte(b, at + 9);
      one_scan = marker == 0xc0 || marker == 0xc1;
      s.refusal = refused_frame(marker, b.substr(at + 4, length - 2));
    }
    at += 2 + length;
    if (marker == kStartOfScan) {
      ++scans;
      if (length < 3 || jpeg_byte(b, at - length + 2) != components) one_scan = false;  // further scans have other components
      at = end_of_scan(b, at);
      if (at == std::string_view::npos) {
        s.end_missing = one_scan && scans == 1 && !b.ends_with(std::string_view("\0\0\0\0", 4));
        return cut();
      }
    }
  }
  return cut();
}

std::string jpeg_trailer(std::string_view b, size_t end) {
  if (end == 0 || end >= b.size()) return "";
  const std::string_view rest = b.substr(end);
  if (std::all_of(rest.begin(), rest.end(), [](char c) { return c == '\0' || c == '\xff'; })) return "";
  if (rest.find("ftyp") != std::string_view::npos) return "a film";
  if (rest.find("\xff\xd8\xff") != std::string_view::npos) return "further pictures";
  return "other data";
}

}  // namespace vitrine
