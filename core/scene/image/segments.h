// The containers of photo files, without decoding pictures: segments of a JPEG, chunks of a PNG, the profile of a TIFF,
// attributes of an EXR. Damaged or cut bytes give what is whole in them; nothing is read beyond their end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
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

// The ICC profile of a TIFF (also BigTIFF): of the page that is the picture, else of another one; empty when there is none.
std::string_view tiff_profile(std::string_view bytes);

// The value of an attribute of the first header of an EXR; empty when there is none of this name and type.
std::string_view exr_attribute(std::string_view bytes, std::string_view name, std::string_view type);

}  // namespace vitrine
