// The codecs of pictures (libjpeg, libpng, libtiff, OpenCV's), in a library of their own that is loaded with the first picture.
// They bring GDAL and 120 more libraries with them, whose symbols take 0.15 s of CPU time to find; most starts of a program (for
// keys, descriptions, help) see no picture. Nothing of them writes to stderr: their messages come back as text.
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

// A decoded strip or tile of a TIFF: `rows` rows of `row_bytes` bytes, samples in the machine's byte order (those of less than 8
// bits and of 9 to 15 are packed, highest bit first).
struct TiffBlock {
  int x = 0, y = 0, width = 0, rows = 0;  // the part of it that lies in the picture
  unsigned plane = 0;                     // of a planar TIFF
  const uint8_t* bytes = nullptr;
  size_t row_bytes = 0;
};

struct TiffRequest {
  uint64_t directory = 0;
  uint64_t width = 0, height = 0;  // what its directory says: libtiff has to understand it in the same way
  unsigned bits = 8, samples = 1;
  bool planar = false;
  unsigned planes = 1;  // of a planar TIFF: how many are wanted
  bool ycbcr = false;   // to be converted: 8 bit, 3 channels
  bool rgba = false;    // one block of the whole picture as 8-bit R, G, B, A, converted by libtiff
};

// All give what went wrong, or nothing.
struct Codecs {
  // A picture of 1 / `reduction` of its size (1, 2, 4, 8). `channels`: 1 = grey, 3 = RGB, 0 = as the file has it. Data that are
  // damaged or end early are an error: libjpeg would fill the rest with grey.
  std::string (*jpeg)(std::string_view bytes, int channels, int reduction, Image8& out);
  // 8-bit or 16-bit; the other one stays empty. 1 (grey), 3 (RGB) or 4 (RGB or grey, with alpha) channels.
  std::string (*png)(std::string_view bytes, Image8& out8, Image16& out16);
  std::string (*tiff)(std::string_view bytes, const TiffRequest& request, const std::function<void(const TiffBlock&)>& put);
  // Other formats. `flags`, `parameters`: cv::ImreadModes, cv::ImwriteFlags. `out` is empty where no codec knows the data.
  std::string (*other)(const std::string& bytes, int flags, cv::Mat& out);
  std::string (*encode)(const std::string& extension, const cv::Mat& mat, const std::vector<int>& parameters, std::string& bytes);
};

// Throws Error{Dependency} when the library cannot be loaded.
const Codecs& codecs();

}  // namespace vitrine
