// Photos made byte by byte for the tests of ingest: EXIF blocks, JPEG and TIFF files with chosen tags.
#pragma once

#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "core/scene/image/image.h"
#include "core/scene/image/ldr.h"

namespace vitrine::test {

// Little or big endian fields of a TIFF structure.
class Fields {
 public:
  explicit Fields(bool big_endian) : big_(big_endian) {}
  void u16(unsigned v) { number(v, 2); }
  void u32(unsigned v) { number(v, 4); }
  void raw(std::string_view s) { bytes += s; }
  std::string bytes;

 private:
  void number(unsigned v, int n) {
    for (int i = 0; i < n; ++i) bytes += static_cast<char>(v >> 8 * (big_ ? n - 1 - i : i));
  }
  bool big_;
};

struct Tag {
  unsigned id;
  char type;              // 's' short, 'l' long, 'r' rational, 'a' text, 'b' byte, 'R' rationals: `text` has their bytes
  unsigned a = 0, b = 1;  // value, or numerator and denominator
  std::string text = {};
};

// One directory whose out-of-line values follow it; `at` is its place in the structure.
inline std::string directory(const std::vector<Tag>& tags, unsigned at, bool big_endian) {
  Fields out(big_endian), values(big_endian);
  const unsigned values_at = at + 2 + 12 * static_cast<unsigned>(tags.size()) + 4;
  out.u16(static_cast<unsigned>(tags.size()));
  for (const Tag& t : tags) {
    out.u16(t.id);
    const unsigned here = values_at + static_cast<unsigned>(values.bytes.size());
    switch (t.type) {
      case 's':
        out.u16(3), out.u32(1), out.u16(t.a), out.u16(0);
        break;
      case 'l':
        out.u16(4), out.u32(1), out.u32(t.a);
        break;
      case 'r':
        out.u16(5), out.u32(1), out.u32(here), values.u32(t.a), values.u32(t.b);
        break;
      case 'b':
        out.u16(1), out.u32(1), out.raw(std::string{static_cast<char>(t.a), 0, 0, 0});
        break;
      case 'R':
        out.u16(5), out.u32(static_cast<unsigned>(t.text.size() / 8)), out.u32(here), values.raw(t.text);
        break;
      default: {
        std::string s = t.text + '\0';
        out.u16(2), out.u32(static_cast<unsigned>(s.size()));
        if (s.size() <= 4)
          s.resize(4), out.raw(s);
        else
          out.u32(here), values.raw(s.size() % 2 ? s + '\0' : s);
      }
    }
  }
  out.u32(0);
  return out.bytes + values.bytes;
}

// "Exif\0\0" + TIFF structure with IFD0 and the EXIF directory.
inline std::string exif_bytes(std::vector<Tag> ifd0, const std::vector<Tag>& exif, bool big_endian = false) {
  ifd0.push_back({0x8769, 'l', 0});
  const unsigned exif_at = 8 + static_cast<unsigned>(directory(ifd0, 8, big_endian).size());
  ifd0.back().a = exif_at;
  Fields header(big_endian);
  header.raw(big_endian ? "MM" : "II");
  header.u16(42);
  header.u32(8);
  return std::string("Exif\0\0", 6) + header.bytes + directory(ifd0, 8, big_endian) + directory(exif, exif_at, big_endian);
}

// Puts an EXIF block behind the start marker of a JPEG.
inline void add_exif(const fs::path& jpeg, const std::string& exif) {
  const std::string bytes = read_file(jpeg);
  Fields segment(true);
  segment.raw("\xff\xe1");
  segment.u16(static_cast<unsigned>(exif.size()) + 2);
  write_file(jpeg, bytes.substr(0, 2) + segment.bytes + exif + bytes.substr(2));
}

// An uncompressed RGB TIFF of 8 or 16 bits with an orientation tag.
inline std::string tiff_bytes(const Image8& image, unsigned orientation, unsigned bits = 8) {
  const unsigned w = static_cast<unsigned>(image.width()), h = static_cast<unsigned>(image.height()), size = w * h * 3 * bits / 8;
  Fields out(false);
  out.raw("II");
  out.u16(42);
  out.u32(8);
  const unsigned pixels_at = 8 + 2 + 12 * 11 + 4 + 6;
  out.u16(11);
  const auto entry = [&](unsigned tag, unsigned type, unsigned count, unsigned value) {
    out.u16(tag), out.u16(type), out.u32(count);
    if (type == 3 && count == 1)
      out.u16(value), out.u16(0);
    else
      out.u32(value);
  };
  entry(256, 4, 1, w), entry(257, 4, 1, h), entry(258, 3, 3, pixels_at - 6), entry(259, 3, 1, 1), entry(262, 3, 1, 2);
  entry(273, 4, 1, pixels_at), entry(274, 3, 1, orientation), entry(277, 3, 1, 3), entry(278, 4, 1, h), entry(279, 4, 1, size);
  entry(284, 3, 1, 1);
  out.u32(0);
  for (int i = 0; i < 3; ++i) out.u16(bits);
  for (uint8_t v : image.data()) {
    if (bits == 16)
      out.u16(v * 257u);
    else
      out.raw({reinterpret_cast<const char*>(&v), 1});
  }
  return out.bytes;
}

// An uncompressed TIFF of 8 or 16 bits, of 3 or 4 channels (alpha, not associated), with a profile where `icc` is not empty; as a
// BigTIFF on request.
template <class T>
std::string tagged_tiff(const Image<T>& image, const std::string& icc, bool bigtiff = false) {
  const unsigned w = static_cast<unsigned>(image.width()), h = static_cast<unsigned>(image.height());
  const unsigned channels = static_cast<unsigned>(image.channels()), bits = 8 * sizeof(T);
  struct Entry {
    unsigned tag, type;
    std::string bytes;
  };
  const auto shorts = [](std::vector<unsigned> v) {
    Fields f(false);
    for (unsigned n : v) f.u16(n);
    return f.bytes;
  };
  const auto word = [](unsigned v) {
    Fields f(false);
    f.u32(v);
    return f.bytes;
  };
  std::vector<Entry> entries{{256, 4, word(w)},
                             {257, 4, word(h)},
                             {258, 3, shorts(std::vector<unsigned>(channels, bits))},
                             {259, 3, shorts({1})},
                             {262, 3, shorts({2})},
                             {273, 4, word(0)},
                             {277, 3, shorts({channels})},
                             {278, 4, word(h)},
                             {279, 4, word(w * h * channels * bits / 8)},
                             {284, 3, shorts({1})}};
  if (channels == 4) entries.push_back({338, 3, shorts({2})});
  if (!icc.empty()) entries.push_back({34675, 7, icc});
  const unsigned offset = bigtiff ? 8 : 4;
  const auto number = [&](Fields& f, unsigned v) {
    f.u32(v);
    if (bigtiff) f.u32(0);
  };
  const unsigned first = bigtiff ? 16 : 8;
  const unsigned behind = first + (bigtiff ? 8 : 2) + static_cast<unsigned>(entries.size()) * (bigtiff ? 20 : 12) + offset;
  unsigned values = 0;
  for (const Entry& e : entries)
    if (e.bytes.size() > offset) values += static_cast<unsigned>(e.bytes.size() + e.bytes.size() % 2);
  entries[5].bytes = word(behind + values);
  Fields out(false);
  out.raw("II");
  out.u16(bigtiff ? 43 : 42);
  if (bigtiff) out.u16(8), out.u16(0);
  number(out, first);
  if (bigtiff)
    number(out, static_cast<unsigned>(entries.size()));
  else
    out.u16(static_cast<unsigned>(entries.size()));
  std::string out_of_line;
  for (const Entry& e : entries) {
    out.u16(e.tag), out.u16(e.type);
    number(out, static_cast<unsigned>(e.bytes.size() / (e.type == 3 ? 2 : e.type == 4 ? 4 : 1)));
    if (e.bytes.size() <= offset) {
      std::string padded = e.bytes;
      padded.resize(offset);
      out.raw(padded);
    } else {
      number(out, behind + static_cast<unsigned>(out_of_line.size()));
      out_of_line += e.bytes + std::string(e.bytes.size() % 2, '\0');
    }
  }
  number(out, 0);
  out.raw(out_of_line);
  for (T v : image.data()) {
    if (bits == 16)
      out.u16(v);
    else
      out.raw(std::string(1, static_cast<char>(v)));
  }
  return out.bytes;
}

// Flat blocks of 16 pixels in clearly different colours, so that JPEG keeps them apart: 3 x 2 blocks, no symmetry.
inline Image8 blocks() {
  const uint8_t colours[6][3] = {{200, 40, 40}, {40, 200, 40}, {40, 40, 200}, {200, 200, 40}, {128, 128, 128}, {30, 30, 30}};
  Image8 image(48, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = colours[y / 16 * 3 + x / 16][c];
  return image;
}

inline Image8 mirrored(const Image8& in) {
  Image8 out = in;
  for (int y = 0; y < in.height(); ++y)
    for (int x = 0; x < in.width(); ++x)
      for (int c = 0; c < 3; ++c) out.at(in.width() - 1 - x, y, c) = in.at(x, y, c);
  return out;
}
inline Image8 turned_clockwise(const Image8& in) {
  Image8 out(in.height(), in.width(), 3);
  for (int y = 0; y < in.height(); ++y)
    for (int x = 0; x < in.width(); ++x)
      for (int c = 0; c < 3; ++c) out.at(in.height() - 1 - y, x, c) = in.at(x, y, c);
  return out;
}
// How a camera stores `shown` under an EXIF orientation: the opposite of what the viewer does. Viewers do: 2 mirror; 3 half a
// turn; 4 mirror, half a turn; 5 mirror, three quarters clockwise; 6 a quarter clockwise; 7 mirror, a quarter clockwise; 8 three
// quarters clockwise.
inline Image8 stored_as(Image8 shown, int orientation) {
  const int clockwise_quarters[] = {0, 0, 0, 2, 2, 3, 1, 1, 3};
  for (int i = 0; i < (4 - clockwise_quarters[orientation]) % 4; ++i) shown = turned_clockwise(shown);
  const bool mirror = orientation == 2 || orientation == 4 || orientation == 5 || orientation == 7;
  return mirror ? mirrored(shown) : shown;
}

}  // namespace vitrine::test
