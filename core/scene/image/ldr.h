// Image input and output for photos, masks and previews (JPEG, PNG, TIFF, HEIC, AVIF; masks also BMP, WebP, PNM). Only ldr.cpp
// includes codec headers.
#pragma once

#include <filesystem>
#include <string>

#include "core/scene/image/image.h"

namespace vitrine {

// Display-referred sRGB values in [0,1], 3 channels RGB (grey replicated, alpha dropped). EXIF orientation is NOT applied.
// Float TIFF samples are returned unchanged.
// Throws Error{Input} with the reason: empty, truncated, damaged or unsupported file.
ImageF read_srgb(const std::filesystem::path& path);
// Display-referred 8-bit RGB at 1 / `reduction` of the size (1, 2, 4, 8). JPEG decodes at reduced size, which is several times
// faster. Not for float files. EXIF orientation is NOT applied.
Image8 read_srgb8(const std::filesystem::path& path, int reduction = 1);
Image8 read_grey8(const std::filesystem::path& path);  // one channel, e.g. a mask
// All channels (RGB order), scaled to [0,1] by the bit depth: 1 (grey), 3 (RGB) or 4 (RGBA, not premultiplied).
ImageF read_unchanged(const std::filesystem::path& path);
// Same, with the orientation tag of a TIFF applied. JPEG and PNG orientation is in EXIF, which masks ignore.
ImageF read_as_oriented(const std::filesystem::path& path);

// Format by extension: .png .jpg .tif. `jpeg_quality` applies to .jpg only. 1 or 3 channels.
void write_ldr(const std::filesystem::path& path, const Image8& image, int jpeg_quality = 95);
void write_png16(const std::filesystem::path& path, const Image16& image);
// Encoded JPEG, for files with embedded images (report.html, GLB).
std::string jpeg_bytes(const Image8& image, int quality);
std::string png_bytes(const Image8& image);

ImageF floats_of(const Image8& image);           // 255 maps to 1
Image8 bytes_of(const ImageF& image);            // clamp, round
Image8 srgb8_from_linear(const ImageF& linear);  // clamp, encode, round
ImageF srgb_from_linear_image(const ImageF& linear);
ImageF linear_from_srgb_image(const ImageF& srgb);

}  // namespace vitrine
