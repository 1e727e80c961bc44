// The containers of photo files, without decoding pictures: segments of a JPEG, chunks of a PNG, fields of a TIFF (also BigTIFF),
// attributes of an EXR. Damaged or cut bytes give what is whole in them; nothing is read beyond their end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace vitrine {

// An unsigned number of `n` bytes; 0 beyond the end, which no valid field that is asked for holds.
uint64_t number_at(std::string_view bytes, size_t at, size_t n, bool big_endian);

// Visits the segments of a JPEG up to the first scan: marker, and the payload's bytes. Stops when `visit` returns false.
// Returns the place behind the start-of-scan marker, 0 when the bytes end before it or the visit stopped.
size_t jpeg_segments(std::string_view bytes, const std::function<bool(unsigned marker, std::string_view payload)>& visit);
bool is_start_of_frame(unsigned marker);

// Visits the chunks of a PNG. Returns whether IEND was met.
bool png_chunks(std::string_view bytes, const std::function<void(std::string_view type, std::string_view data)>& visit);

// A PNG with what its pixels need only: no profile, text or gamma, of which libpng writes its opinion to stderr.
std::string png_pixels(std::string_view bytes);

// A field of the directory that holds the largest picture (a thumbnail may come first); of another one when that lacks it.
struct TiffField {
  unsigned type = 0;
  uint64_t count = 0;
  std::string_view bytes;  // of its values
  bool big_endian = false;
  // Whole numbers of type BYTE, SHORT, LONG, LONG8; 0 for others and beyond the count.
  uint64_t number(size_t index = 0) const;
};
std::optional<TiffField> tiff_field(std::string_view bytes, unsigned tag);

// The value of an attribute of the first header of an EXR; empty when there is none of this name and type.
std::string_view exr_attribute(std::string_view bytes, std::string_view name, std::string_view type);

}  // namespace vitrine
