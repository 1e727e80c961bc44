// Container parsing without decoding: JPEG segments, PNG chunks, the ICC profile of a TIFF, EXR attributes. From damaged or
// truncated data, the complete parts are returned; no reads beyond the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace vitrine {

// Unsigned integer of `n` bytes; 0 beyond the end (valid fields are never 0).
uint64_t number_at(std::string_view bytes, size_t at, size_t n, bool big_endian);

// Calls `visit` with marker and payload of each JPEG segment before the first scan. Stops if `visit` returns false. Returns the
// offset after the start-of-scan marker, or 0 if the data end earlier or `visit` stopped.
size_t jpeg_segments(std::string_view bytes, const std::function<bool(unsigned marker, std::string_view payload)>& visit);
bool is_start_of_frame(unsigned marker);

// Calls `visit` for each PNG chunk. Returns true if IEND was found.
bool png_chunks(std::string_view bytes, const std::function<void(std::string_view type, std::string_view data)>& visit);

// ICC profile of a TIFF or BigTIFF: from the main page, else from another page; empty if none.
std::string_view tiff_profile(std::string_view bytes);

// Attribute value from the first header of an EXR; empty if there is no attribute of this name and type.
std::string_view exr_attribute(std::string_view bytes, std::string_view name, std::string_view type);

// JPEG type and true end of the image data. Phones and cameras append videos (motion photos), further images (MPF, gain maps)
// and zeros, and embedded thumbnails contain end markers; so neither the first nor the last end marker proves that a file is
// complete. The parser follows the structure: segments, then the entropy-coded data of each scan up to the next marker.
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
