// The pages of a TIFF (classic or BigTIFF, either byte order) as its directories describe them, and the one that is the picture.
// Nothing is decoded here, so the size of a photo, its kind and why it cannot be read are known before any memory is asked for.
//
// A TIFF may begin with a thumbnail, hold the picture in a sub-directory (SubIFDs), or be a raw photo whose first page is a
// preview (DNG, NEF, CR2, ARW): the picture is the largest page that is not marked as reduced and is no mask of another page.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

struct TiffPage {
  uint64_t directory = 0;  // its place in the file
  uint64_t width = 0, height = 0;
  unsigned bits = 1, samples = 1;
  unsigned sample_format = 1;  // 1 unsigned, 2 signed, 3 IEEE floating point, 4 undefined (as unsigned), 5, 6 complex
  unsigned photometric = 1, compression = 1, orientation = 1;
  bool equal_samples = true;  // all channels have the same bits and format
  bool planar = false;        // one plane of strips or tiles per channel
  bool reduced = false, mask = false;
  bool sub_directory = false;
  uint64_t exif_directory = 0;                 // the place of its EXIF fields; 0 = none
  std::vector<uint16_t> palette;               // ColorMap: all reds, all greens, all blues, of 16 bits
  std::optional<std::vector<unsigned>> extra;  // ExtraSamples: 0 unspecified, 1 associated alpha, 2 unassociated alpha
};

struct TiffPages {
  std::vector<TiffPage> pages;  // in the order of the file, each followed by its sub-directories
  size_t picture = 0;           // which of them is read
  bool big = false, big_endian = false;
  std::string raw;       // the kind of raw photo that this is ("DNG"), or empty
  bool damaged = false;  // a directory lies outside of the file, or they form a circle

  const TiffPage& chosen() const { return pages[picture]; }
};

bool is_tiff(std::string_view bytes);  // classic or BigTIFF
// `bytes` may be the beginning of a file; directories behind it are then missing. No pages: there is no directory.
TiffPages tiff_pages(std::string_view bytes);

// Its EXIF fields as a small classic TIFF of their own, "Exif\0\0" before it: libexif knows no BigTIFF, begins with the first
// page, and searches 64 KiB, behind which most programs write their directories. Empty when there are none.
std::string tiff_exif_block(std::string_view bytes);

// How many channels of `page` are the colours (1 or 3), and where its alpha is, if it has one.
struct TiffChannels {
  unsigned colours = 1;
  std::optional<unsigned> alpha;
  bool premultiplied = false;
  unsigned dropped = 0;  // further channels, of no known meaning
};
TiffChannels tiff_channels(const TiffPage& page);

// Why the picture of these pages is not read, with the way out; empty when it is.
std::string tiff_refusal(const TiffPages& pages);
// One sentence for each thing that is assumed or left out when it is read.
std::vector<std::string> tiff_notes(const TiffPages& pages);

}  // namespace vitrine
