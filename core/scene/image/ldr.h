// Photographs, masks and previews (JPEG, PNG, TIFF; masks also BMP, WebP, PNM); no header of a codec leaves ldr.cpp.
#pragma once

#include <filesystem>
#include <string>

#include "core/scene/image/image.h"

namespace vitrine {

// Display-referred sRGB values in [0,1], 3 channels RGB (grey repeated, alpha dropped); orientation is NOT applied. Samples of a
// float TIFF are as they are.
// Throws Error{Input} with the reason: empty file, truncated, damaged, a kind of picture that is not read.
ImageF read_srgb(const std::filesystem::path& path);
// As display-referred 8-bit RGB, 1 / `reduction` of its size (1, 2, 4, 8): a JPEG is then decoded small, which is several times
// faster. Not for float files. EXIF orientation is NOT applied.
Image8 read_srgb8(const std::filesystem::path& path, int reduction = 1);
Image8 read_grey8(const std::filesystem::path& path);  // one channel, e.g. a mask
// All channels (RGB order), scaled to [0,1] by the bit depth: 1 (grey), 3 (RGB) or 4 (with alpha, which multiplies nothing).
ImageF read_unchanged(const std::filesystem::path& path);
// The same, rows and columns where the orientation tag of a TIFF says (that of JPEG and PNG is EXIF, which masks do not follow).
ImageF read_as_oriented(const std::filesystem::path& path);

// Format by extension: .png .jpg .tif. `jpeg_quality` for .jpg only. 1 or 3 channels.
void write_ldr(const std::filesystem::path& path, const Image8& image, int jpeg_quality = 95);
void write_png16(const std::filesystem::path& path, const Image16& image);
// The bytes of such a file, for documents and formats that carry pictures inside (report.html, GLB).
std::string jpeg_bytes(const Image8& image, int quality);
std::string png_bytes(const Image8& image);

ImageF floats_of(const Image8& image);           // 255 is 1
Image8 bytes_of(const ImageF& image);            // clamp, round
Image8 srgb8_from_linear(const ImageF& linear);  // clamp, encode, round
ImageF srgb_from_linear_image(const ImageF& linear);
ImageF linear_from_srgb_image(const ImageF& srgb);

}  // namespace vitrine
