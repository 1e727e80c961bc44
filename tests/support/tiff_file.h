// TIFF files of every kind, written by libtiff, that all hold the same picture.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include <half.h>
#include <tiffio.h>

#include "core/foundation/base/file.h"
#include "core/scene/image/image.h"

namespace vitrine::test {

struct TiffDesc {
  const char* name = "";
  unsigned bits = 8, samples = 3, format = SAMPLEFORMAT_UINT, photometric = PHOTOMETRIC_RGB, compression = COMPRESSION_NONE;
  unsigned predictor = 1, orientation = 1, subfile = 0;
  bool planar = false, tiled = false, big = false, big_endian = false;
  std::vector<uint16_t> extra = {};
  bool palette = false;
};

// A value of 0..255 for each sample; of `levels` steps, so that fewer bits hold the same picture.
inline unsigned tiff_sample(int x, int y, unsigned c, unsigned bits = 8) {
  const unsigned v = (unsigned(x) * 5 + unsigned(y) * 11 + c * 67 + unsigned(x * y) % 7) % 256;
  return bits >= 8 ? v : (v >> (8 - bits)) * 255 / ((1u << bits) - 1);
}

inline Image8 tiff_picture(int width, int height, unsigned channels, unsigned bits = 8) {
  Image8 image(width, height, int(channels));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (unsigned c = 0; c < channels; ++c) image.at(x, y, int(c)) = uint8_t(tiff_sample(x, y, c, bits));
  return image;
}

// Samples of one row, packed as the file wants them; `value` in 0..255.
inline void put_tiff_sample(std::vector<uint8_t>& row, size_t index, unsigned value, const TiffDesc& d) {
  const auto store = [&](auto v) { std::memcpy(&row[index * sizeof v], &v, sizeof v); };
  if (d.format == SAMPLEFORMAT_IEEEFP) {
    const float v = float(value) / 255.f;
    if (d.bits == 16) store(half(v).bits());
    if (d.bits == 32) store(v);
    if (d.bits == 64) store(double(v));
    return;
  }
  if (d.bits == 8) return store(uint8_t(value));
  if (d.bits == 16) return store(uint16_t(value * 257));
  if (d.bits == 32) return store(uint32_t(value * 16843009u));
  const unsigned v = d.bits < 8 ? value >> (8 - d.bits) : value * ((1u << d.bits) - 1) / 255;
  for (unsigned b = 0; b < d.bits; ++b)
    if (v >> (d.bits - 1 - b) & 1) row[(index * d.bits + b) / 8] |= uint8_t(0x80 >> (index * d.bits + b) % 8);
}

inline void add_tiff_page(TIFF* tiff, int width, int height, const TiffDesc& d, unsigned offset = 0) {
  constexpr unsigned kTile = 16, kRowsPerStrip = 7;
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, d.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, d.samples);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, d.format);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, d.photometric);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, d.compression);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, d.planar ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, d.orientation);
  if (d.subfile) TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, d.subfile);
  if (!d.extra.empty()) TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, d.extra.size(), d.extra.data());
  if (d.predictor != 1) TIFFSetField(tiff, TIFFTAG_PREDICTOR, d.predictor);
  if (d.compression == COMPRESSION_JPEG) TIFFSetField(tiff, TIFFTAG_JPEGQUALITY, 100);
  if (d.photometric == PHOTOMETRIC_YCBCR && d.compression != COMPRESSION_JPEG) TIFFSetField(tiff, TIFFTAG_YCBCRSUBSAMPLING, 1, 1);
  std::vector<uint16_t> colours[3];
  if (d.photometric == PHOTOMETRIC_PALETTE) {
    for (unsigned c = 0; c < 3; ++c)
      for (unsigned i = 0; i < 1u << d.bits; ++i)
        colours[c].push_back(uint16_t((i * (c + 1) * 255 / ((1u << d.bits) - 1)) % 256 * 257));
    TIFFSetField(tiff, TIFFTAG_COLORMAP, colours[0].data(), colours[1].data(), colours[2].data());
  }
  const unsigned planes = d.planar ? d.samples : 1, together = d.planar ? 1 : d.samples;
  const auto row_of = [&](int x0, int y, int columns, unsigned plane, size_t bytes) {
    std::vector<uint8_t> row(bytes);
    for (int x = 0; x < columns; ++x)
      for (unsigned s = 0; s < together; ++s) {
        unsigned value = (tiff_sample(x0 + x, y, d.planar ? plane : s, d.bits < 8 ? d.bits : 8) + offset) % 256;
        if (d.photometric == PHOTOMETRIC_MINISWHITE) value = 255 - value;
        put_tiff_sample(row, size_t(x) * together + s, value, d);
      }
    return row;
  };
  if (d.tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, kTile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, kTile);
    const size_t row_bytes = size_t(TIFFTileRowSize(tiff));
    uint32_t tile = 0;
    for (unsigned plane = 0; plane < planes; ++plane)
      for (int y0 = 0; y0 < height; y0 += kTile)
        for (int x0 = 0; x0 < width; x0 += kTile) {
          std::vector<uint8_t> bytes;
          for (int y = y0; y < y0 + int(kTile); ++y) {
            const std::vector<uint8_t> row = row_of(x0, y, kTile, plane, row_bytes);
            bytes.insert(bytes.end(), row.begin(), row.end());
          }
          TIFFWriteEncodedTile(tiff, tile++, bytes.data(), tmsize_t(bytes.size()));
        }
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, d.compression == COMPRESSION_JPEG ? 16 : kRowsPerStrip);
    for (unsigned plane = 0; plane < planes; ++plane)
      for (int y = 0; y < height; ++y) {
        std::vector<uint8_t> row = row_of(0, y, width, plane, size_t(TIFFScanlineSize(tiff)));
        TIFFWriteScanline(tiff, row.data(), uint32_t(y), uint16_t(plane));
      }
  }
  TIFFWriteDirectory(tiff);
}

inline TIFF* open_tiff(const fs::path& path, const TiffDesc& d) {
  TIFFSetWarningHandler(nullptr);
  const std::string mode = std::string("w") + (d.big ? "8" : "4") + (d.big_endian ? "b" : "l");
  return TIFFOpen(path.c_str(), mode.c_str());
}

inline void write_tiff(const fs::path& path, const TiffDesc& d, int width = 37, int height = 29) {
  TIFF* const tiff = open_tiff(path, d);
  add_tiff_page(tiff, width, height, d);
  TIFFClose(tiff);
}

}  // namespace vitrine::test
