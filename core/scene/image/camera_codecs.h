// Decoders of the files of phones and cameras (libheif, LibRaw) in a shared library of their own, which is loaded with the first
// such file: libheif depends on encoders of video, LibRaw on OpenMP. Either may be left out of a build; its functions then
// return how to build with it.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "core/scene/image/image.h"

namespace vitrine {

// Metadata of a raw photo, read without its pixels. 0 and empty: unknown.
struct RawFacts {
  std::string camera;              // maker and model
  int width = 0, height = 0;       // as stored
  int orientation = 1;             // EXIF 1..8
  std::array<float, 4> balance{};  // multipliers of the camera's white balance: R, G, B, second G
  bool colors_known = false;       // LibRaw, or the file, has the camera's colour matrix
  double exposure_s = 0, f_number = 0, iso = 0, focal_mm = 0, focal_35mm = 0;
};

struct RawRequest {
  std::array<float, 4> balance{};  // all 0: that of the photo
  bool half = false;               // half of the size, without interpolation of colours
};

// All functions return an error message, empty on success.
struct CameraCodecs {
  // HEIC, AVIF: the primary picture as displayed, in the colours of the file. Either 8-bit, or 16-bit for files of more bits;
  // the other output stays empty. 3 channels, or 4 with alpha if `alpha`.
  std::string (*heif)(std::string_view bytes, bool alpha, Image8& out8, Image16& out16);
  std::string (*raw_facts)(const std::string& path, RawFacts& out);
  // Linear Rec. 709, as stored (not turned). 1 is where the first of the balanced channels saturates (stages/ingest/README.md,
  // "Phones and cameras"); brighter values are kept.
  std::string (*raw)(const std::string& path, const RawRequest& request, ImageF& out);
  // "libheif 1.15.1 (HEVC, AV1)", "LibRaw 0.20.2", or why they are missing.
  std::string (*heif_version)();
  std::string (*raw_version)();
};

// Throws Error{Dependency} if the library cannot be loaded.
const CameraCodecs& camera_codecs();

}  // namespace vitrine
