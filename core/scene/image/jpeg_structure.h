// JPEG type and true end of the image data. Phones and cameras append videos (motion photos), further images (MPF, gain maps)
// and zeros, and embedded thumbnails contain end markers; so neither the first nor the last end marker proves that a file is
// complete. The parser follows the structure: segments, then the entropy-coded data of each scan up to the next marker.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace vitrine {

struct JpegStructure {
  std::string damage;   // reason why the image is incomplete; empty if complete
  std::string refusal;  // reason why this type of JPEG is not supported, with a workaround; empty if supported
  size_t end = 0;       // offset after the end marker; later bytes are not part of the image
  // Damaged, possibly only by a missing end marker: one scan, no padding after it. Only decoding can decide.
  bool end_missing = false;
};

// For a complete file that starts with ff d8.
JpegStructure jpeg_structure(std::string_view bytes);
// Type of data after the image: "a film", "further pictures", "other data"; empty for none or padding.
std::string jpeg_trailer(std::string_view bytes, size_t end);

}  // namespace vitrine
