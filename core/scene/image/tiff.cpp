#include "core/scene/image/tiff_pages.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <half.h>

#include "core/scene/image/codecs.h"

namespace vitrine {

namespace {

constexpr unsigned kPhotometricMinIsWhite = 0, kPhotometricPalette = 3, kPhotometricYcbcr = 6, kCompressionJpeg = 7;
constexpr unsigned kFloatingPoint = 3;

// Sample index of each image channel.
struct TiffLayout {
  std::vector<unsigned> source;
  unsigned samples = 1;  // samples per pixel in a block: 1 in a planar file
  bool planar = false;
};

// `read(row, index)` returns sample `index` of a row of a block.
template <class T, class Read>
void place_samples(Image<T>& out, const TiffBlock& b, const TiffLayout& layout, Read&& read) {
  const unsigned channels = static_cast<unsigned>(out.channels());
  for (int y = 0; y < b.rows; ++y) {
    const uint8_t* const row = b.bytes + size_t(y) * b.row_bytes;
    T* const to = out.pixel(b.x, b.y + y);
    for (unsigned c = 0; c < channels; ++c) {
      if (layout.planar && layout.source[c] != b.plane) continue;
      const size_t first = layout.planar ? 0 : layout.source[c];
      for (size_t x = 0; x < size_t(b.width); ++x) to[x * channels + c] = read(row, first + x * layout.samples);
    }
  }
}

// Rows that are copied unchanged.
template <class T>
bool copied(Image<T>& out, const TiffBlock& b, const TiffLayout& layout, bool plain) {
  if (!plain || layout.planar || layout.samples != static_cast<unsigned>(out.channels())) return false;
  for (int y = 0; y < b.rows; ++y)
    std::memcpy(out.pixel(b.x, b.y + y), b.bytes + size_t(y) * b.row_bytes, size_t(b.width) * layout.samples * sizeof(T));
  return true;
}

template <class T>
T loaded(const uint8_t* row, size_t index) {
  T v;
  std::memcpy(&v, row + index * sizeof(T), sizeof(T));
  return v;
}

unsigned packed_bits(const uint8_t* row, size_t index, unsigned bits) {  // bits <= 16
  const size_t at = index * bits, byte = at / 8, shift = at % 8, bytes = (shift + bits + 7) / 8;
  uint32_t window = 0;
  for (size_t i = 0; i < bytes; ++i) window = window << 8 | row[byte + i];
  return window >> (8 * bytes - shift - bits) & ((1u << bits) - 1);
}

void place_bytes(Image8& out, const TiffBlock& b, const TiffLayout& layout, const TiffPage& page) {
  const bool inverted = page.photometric == kPhotometricMinIsWhite;
  if (copied(out, b, layout, page.bits == 8 && !inverted)) return;
  const unsigned highest = (1u << page.bits) - 1, flip = inverted ? highest : 0, scale = 255 % highest == 0 ? 255 / highest : 0;
  if (page.bits == 8)
    place_samples(out, b, layout, [&](const uint8_t* row, size_t i) { return static_cast<uint8_t>(row[i] ^ flip); });
  else
    place_samples(out, b, layout, [&](const uint8_t* row, size_t i) {
      const unsigned v = packed_bits(row, i, page.bits) ^ flip;
      return static_cast<uint8_t>(scale ? v * scale : (v * 510 + highest) / (2 * highest));
    });
}

void place_words(Image16& out, const TiffBlock& b, const TiffLayout& layout, const TiffPage& page) {
  const bool inverted = page.photometric == kPhotometricMinIsWhite;
  if (copied(out, b, layout, page.bits == 16 && !inverted)) return;
  if (page.bits == 16)
    place_samples(out, b, layout, [&](const uint8_t* row, size_t i) {
      const uint16_t v = loaded<uint16_t>(row, i);
      return static_cast<uint16_t>(inverted ? 65535 - v : v);
    });
  else if (page.bits == 32)
    place_samples(out, b, layout, [&](const uint8_t* row, size_t i) {
      const uint32_t v = loaded<uint32_t>(row, i);
      return static_cast<uint16_t>(((inverted ? ~v : v) + uint64_t(32768)) / 65537);  // 65537 * 65535 is the 32-bit maximum
    });
  else {
    const uint64_t highest = (1u << page.bits) - 1;
    place_samples(out, b, layout, [&](const uint8_t* row, size_t i) {
      const uint64_t v = packed_bits(row, i, page.bits);
      return static_cast<uint16_t>(((inverted ? highest - v : v) * 2 * 65535 + highest) / (2 * highest));
    });
  }
}

void place_floats(ImageF& out, const TiffBlock& b, const TiffLayout& layout, const TiffPage& page) {
  if (copied(out, b, layout, page.bits == 32)) return;
  if (page.bits == 16)
    place_samples(out, b, layout, [](const uint8_t* row, size_t i) {
      half h;
      h.setBits(loaded<uint16_t>(row, i));
      return float(h);
    });
  else if (page.bits == 32)
    place_samples(out, b, layout, [](const uint8_t* row, size_t i) { return loaded<float>(row, i); });
  else
    place_samples(out, b, layout, [](const uint8_t* row, size_t i) {
      const double v = loaded<double>(row, i);  // beyond float range: infinite
      constexpr double kMost = std::numeric_limits<float>::max();
      return std::abs(v) > kMost ? std::copysign(std::numeric_limits<float>::infinity(), static_cast<float>(v > 0 ? 1 : -1))
                                 : static_cast<float>(v);
    });
}

void place_palette(Image8& out, const TiffBlock& b, const TiffPage& page) {
  // Palette colours are 16 bit; old writers stored 8-bit values.
  const bool short_values = std::all_of(page.palette.begin(), page.palette.end(), [](uint16_t v) { return v < 256; });
  const size_t colours = size_t(1) << page.bits;
  for (int y = 0; y < b.rows; ++y)
    for (int x = 0; x < b.width; ++x) {
      const size_t i = packed_bits(b.bytes + size_t(y) * b.row_bytes, size_t(x), page.bits);
      for (size_t c = 0; c < 3; ++c) {
        const uint16_t v = page.palette[c * colours + i];
        out.at(b.x + x, b.y + y, int(c)) = static_cast<uint8_t>(short_values ? v : v >> 8);
      }
    }
}

// Expands grey with alpha to four channels, like PNG files.
template <class T>
void widen(Image<T>& image) {
  if (image.channels() != 2) return;
  Image<T> wide(image.width(), image.height(), 4);
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    const T* const from = &image.data()[2 * i];
    T* const to = &wide.data()[4 * i];
    to[0] = to[1] = to[2] = from[0];
    to[3] = from[1];
  }
  image = std::move(wide);
}

template <class T>
void divide_by_alpha(Image<T>& image) {
  const size_t channels = size_t(image.channels());
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    T* const p = &image.data()[i * channels];
    const T alpha = p[channels - 1];
    if (!(alpha > 0)) continue;
    for (size_t c = 0; c + 1 < channels; ++c) {
      if constexpr (std::is_floating_point_v<T>) {
        p[c] /= alpha;
      } else {
        constexpr uint64_t kFull = std::numeric_limits<T>::max();
        p[c] = static_cast<T>(std::min(kFull, (p[c] * 2 * kFull + alpha) / (2 * uint64_t(alpha))));
      }
    }
  }
}

}  // namespace

std::string read_tiff(std::string_view bytes, const TiffPages& pages, AnyImage& out) {
  const TiffPage& page = pages.chosen();
  const TiffChannels channels = tiff_channels(page);
  const bool palette = page.photometric == kPhotometricPalette, ycbcr = page.photometric == kPhotometricYcbcr;
  const bool rgba = ycbcr && page.compression != kCompressionJpeg;
  TiffLayout layout{.source = {}, .samples = rgba ? 4 : page.planar ? 1 : page.samples, .planar = page.planar && !rgba};
  for (unsigned c = 0; c < channels.colours; ++c) layout.source.push_back(c);
  if (channels.alpha && !rgba) layout.source.push_back(*channels.alpha);
  const unsigned planes = *std::max_element(layout.source.begin(), layout.source.end()) + 1;
  const int width = static_cast<int>(page.width), height = static_cast<int>(page.height);
  const int count = palette ? 3 : static_cast<int>(layout.source.size());
  if (page.sample_format == kFloatingPoint)
    out = ImageF(width, height, count);
  else if (page.bits <= 8)
    out = Image8(width, height, count);
  else
    out = Image16(width, height, count);

  const TiffRequest request{.directory = page.directory,
                            .width = page.width,
                            .height = page.height,
                            .bits = page.bits,
                            .samples = page.samples,
                            .planar = page.planar,
                            .planes = planes,
                            .ycbcr = ycbcr,
                            .rgba = rgba};
  const std::string why = codecs().tiff(bytes, request, [&](const TiffBlock& block) {
    if (palette)
      place_palette(std::get<Image8>(out), block, page);
    else if (auto* const floats = std::get_if<ImageF>(&out))
      place_floats(*floats, block, layout, page);
    else if (auto* const words = std::get_if<Image16>(&out))
      place_words(*words, block, layout, page);
    else
      place_bytes(std::get<Image8>(out), block, layout, page);
  });
  if (!why.empty()) return why;
  std::visit(
      [&](auto& image) {
        if (rgba) return;
        if (channels.alpha && channels.premultiplied) divide_by_alpha(image);
        if (channels.alpha) widen(image);
      },
      out);
  return {};
}

}  // namespace vitrine
