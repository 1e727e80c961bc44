// Photo header inspection without decoding: format and size (for memory planning), and truncation. Decoders silently fill
// truncated files with grey, which would enter the reconstruction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace vitrine {

enum class PhotoFormat { Unknown, Jpeg, Png, Tiff, Exr, Heif, Raw };

struct Probe {
  PhotoFormat format = PhotoFormat::Unknown;
  uint64_t width = 0, height = 0;  // as stored (HEIF: as displayed); 0 if not found in these bytes
  bool float_samples = false;      // TIFF with floating-point samples: linear, not sRGB
  int orientation = 1;             // for TIFF; other formats store it in the EXIF block, HEIF is decoded upright
};

// `bytes` may be the beginning of a file.
Probe probe_photo(std::string_view bytes);
// Reason to refuse decoding this many pixels from a file of this size, or empty: more than any use requires, or more than the
// file can hold, i.e. a damaged header. A decoder would allocate first.
std::string implausible_size(const Probe& probe, size_t file_bytes);
// Missing parts at the end of a complete file's bytes, or empty.
std::string missing_end(std::string_view bytes);
// EXIF block in libexif format ("Exif\0\0" + TIFF structure); empty if there is none.
std::string exif_block(std::string_view bytes);

}  // namespace vitrine
