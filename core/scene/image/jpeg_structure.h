// Where a JPEG really ends, and which kind of JPEG it is. Phones and cameras append films (motion photos), further pictures (MPF,
// gain maps) and zeros, and thumbnails inside hold end markers of their own; so neither the first nor the last end marker of a
// file says whether it is whole. The structure is followed instead: segments, then the coded data of a scan up to the next
// marker.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace vitrine {

struct JpegStructure {
  std::string damage;   // why the picture is not whole; empty when it is
  std::string refusal;  // why this kind of JPEG is not read, and the way out; empty when it is read
  size_t end = 0;       // behind the end marker; what follows does not belong to the picture
  // Damaged, but perhaps by nothing else than the missing end marker: there is one scan, and no filling behind it. A decoder
  // tells.
  bool end_missing = false;
};

// For a whole file that begins with ff d8.
JpegStructure jpeg_structure(std::string_view bytes);
// What follows the picture: "a film", "further pictures", "other data"; empty when it is nothing or padding.
std::string jpeg_trailer(std::string_view bytes, size_t end);

}  // namespace vitrine
