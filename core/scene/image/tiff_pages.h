// Page directory of a TIFF (classic or BigTIFF, either byte order) and selection of the main page. Only directories are read,
// no pixels: image size, image type and the reason for a refusal are available before any allocation.
//
// A TIFF may start with a thumbnail, store the image in a sub-directory (SubIFDs), or be a raw photo whose first page is a
// preview (DNG, NEF, CR2, ARW). The main page is the largest page that is neither marked as reduced nor a mask of another page.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/scene/image/image.h"

namespace vitrine {

struct TiffPage {
  uint64_t directory = 0;  // offset in the file
  uint64_t width = 0, height = 0;
  unsigned bits = 1, samples = 1;
  unsigned sample_format = 1;  // 1 unsigned, 2 signed, 3 IEEE floating point, 4 undefined (as unsigned), 5, 6 complex
  unsigned photometric = 1, compression = 1, orientation = 1;
  bool equal_samples = true;  // all channels have the same bits and format
  bool planar = false;        // one plane of strips or tiles per channel
  bool reduced = false, mask = false;
  bool sub_directory = false;
  uint64_t exif_directory = 0;                 // offset of its EXIF fields; 0 = none
  std::vector<uint16_t> palette;               // ColorMap, 16 bit: all reds, all greens, all blues
  std::optional<std::vector<unsigned>> extra;  // ExtraSamples: 0 unspecified, 1 associated alpha, 2 unassociated alpha
};

struct TiffPages {
  std::vector<TiffPage> pages;  // in file order, each followed by its sub-directories
  size_t picture = 0;           // index of the main page
  bool big = false, big_endian = false;
  std::string raw;       // type of raw photo ("DNG"), or empty
  bool damaged = false;  // a directory is outside the file, or directories form a cycle

  const TiffPage& chosen() const { return pages[picture]; }
};

bool is_tiff(std::string_view bytes);  // classic or BigTIFF
// `bytes` may be the beginning of a file; directories behind it are missing. No pages: no directory found.
TiffPages tiff_pages(std::string_view bytes);

// EXIF fields of a TIFF as a separate small classic TIFF prefixed with "Exif\0\0"; empty if there are none. Needed because
// libexif does not support BigTIFF, starts at the first page, and reads only the first 64 KiB, while most programs write the
// directories at the end.
std::string tiff_exif_block(std::string_view bytes);

// Number of colour channels of `page` (1 or 3) and index of its alpha channel, if any.
struct TiffChannels {
  unsigned colours = 1;
  std::optional<unsigned> alpha;
  bool premultiplied = false;
  unsigned dropped = 0;  // further channels of unknown meaning
};
TiffChannels tiff_channels(const TiffPage& page);

// Reason why the main page is not supported, with a workaround; empty if it is supported.
std::string tiff_refusal(const TiffPages& pages);
// One sentence for each assumption or omission when reading.
std::vector<std::string> tiff_notes(const TiffPages& pages);

// TIFF reader: contiguous and planar, strips and tiles, 1 to 16 and 32 bits, half, float and double, grey, RGB, palettes and
// YCbCr, all libtiff compressions, classic and BigTIFF. tiff_pages.h reports unsupported files.

// Grey (1 channel) or RGB (3), with alpha 4 channels; up to 8 bits as 8, up to 16 and 32 bits as 16, floating point as float.
// Premultiplied colours are divided by alpha. The orientation of the page is not applied.
using AnyImage = std::variant<Image8, Image16, ImageF>;

// Returns an error message, empty on success. `pages` are those of `bytes`, and tiff_refusal(pages) is empty.
std::string read_tiff(std::string_view bytes, const TiffPages& pages, AnyImage& out);

}  // namespace vitrine
