// Image codecs (libjpeg, libpng, libtiff, OpenCV) in a separate shared library that is loaded with the first image. OpenCV
// depends on GDAL and 120 more libraries, whose symbol resolution takes 0.15 s of CPU time; most program starts (cache keys,
// descriptions, help) decode no image. Codec messages are returned as text, never printed to stderr.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/image.h"

namespace cv {
class Mat;
}

namespace vitrine {

// Decoded strip or tile of a TIFF: `rows` rows of `row_bytes` bytes, samples in native byte order (samples of less than 8 bits
// and of 9 to 15 bits are packed, most significant bit first).
struct TiffBlock {
  int x = 0, y = 0, width = 0, rows = 0;  // part inside the image
  unsigned plane = 0;                     // for planar TIFF
  const uint8_t* bytes = nullptr;
  size_t row_bytes = 0;
};

struct TiffRequest {
  uint64_t directory = 0;
  uint64_t width = 0, height = 0;  // from the directory; libtiff must report the same
  unsigned bits = 8, samples = 1;
  bool planar = false;
  unsigned planes = 1;  // for planar TIFF: number of planes to read
  bool ycbcr = false;   // convert to RGB: 8 bit, 3 channels
  bool rgba = false;    // one block for the whole image as 8-bit R, G, B, A, converted by libtiff
};

// All functions return an error message, empty on success.
struct Codecs {
  // Decodes at 1 / `reduction` of the size (1, 2, 4, 8). `channels`: 1 = grey, 3 = RGB, 0 = as in the file. Damaged or
  // truncated data are an error: libjpeg would fill the rest with grey.
  std::string (*jpeg)(std::string_view bytes, int channels, int reduction, Image8& out);
  // Either 8-bit or 16-bit; the other output stays empty. 1 (grey), 3 (RGB) or 4 (RGB or grey, with alpha) channels.
  std::string (*png)(std::string_view bytes, Image8& out8, Image16& out16);
  std::string (*tiff)(std::string_view bytes, const TiffRequest& request, const std::function<void(const TiffBlock&)>& put);
  // Other formats. `flags`, `parameters`: cv::ImreadModes, cv::ImwriteFlags. `out` is empty if no codec accepts the data.
  std::string (*other)(const std::string& bytes, int flags, cv::Mat& out);
  std::string (*encode)(const std::string& extension, const cv::Mat& mat, const std::vector<int>& parameters, std::string& bytes);
};

// Throws Error{Dependency} if the library cannot be loaded.
const Codecs& codecs();

}  // namespace vitrine
