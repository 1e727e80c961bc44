// What the first bytes of a photo say without decoding it: its format and size (so that memory can be planned), and whether
// its end is missing (decoders repair truncated files in silence, and grey halves would go into the reconstruction).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace vitrine {

enum class PhotoFormat { Unknown, Jpeg, Png, Tiff, Exr };

struct Probe {
  PhotoFormat format = PhotoFormat::Unknown;
  uint64_t width = 0, height = 0;  // as stored; 0 when these bytes do not say
  bool float_samples = false;      // a TIFF of floating-point samples: linear, not sRGB
  int orientation = 1;             // of a TIFF's page; the one of other formats is in their EXIF block
};

// `bytes` may be the beginning of a file.
Probe probe_photo(std::string_view bytes);
// Why pixels of this size are not decoded from a file of so many bytes, or empty: too many for any use, or so many more than the
// file can hold that its header is damaged (a decoder asks for the memory before it finds out).
std::string implausible_size(const Probe& probe, size_t file_bytes);
// For a whole file: what is missing at its end, or empty.
std::string missing_end(std::string_view bytes);
// The EXIF block in the form libexif wants ("Exif\0\0" + TIFF structure); empty when there is none.
std::string exif_block(std::string_view bytes);

}  // namespace vitrine
