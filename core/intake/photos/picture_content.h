// Classifies a picture by its pixels: mask, map or cut-out. Confirms the role suggested by a file name; photographs
// never match, so that a photo called carnival_mask.jpg stays a photo. Files that cannot be decoded match nothing.
#pragma once

#include <filesystem>
#include <map>

#include "core/scene/image/probe.h"

namespace vitrine {

struct MaskLook {
  bool both = false;   // require pixels inside and outside the class, unlike an all-black or all-white photo
  bool alpha = true;   // accept a colour picture whose alpha channel has few levels
  bool quick = false;  // accept a PNG of very few bytes without decoding: for files whose names already suggest a mask
};
// Few grey levels, few painted colours, or such an alpha channel.
bool looks_like_mask(const std::filesystem::path& path, const MaskLook& look = {});
// One channel, or three equal ones, next to a photo that has colour (or fewer bits); or painted by a colour map of few colours.
bool looks_like_depth(const std::filesystem::path& path, const std::filesystem::path& photo);
// Colours that are unit vectors, 2 c - 1 (or c, clipped at 0), or achromatic.
bool looks_like_normals(const std::filesystem::path& path);
// Few levels, as scanners write them (0, 1, 2), or a map like depth.
bool looks_like_confidence(const std::filesystem::path& path, const std::filesystem::path& photo);
// Areas of one value each: classes or instances, as numbers or as colours.
bool looks_like_labels(const std::filesystem::path& path);
// A pass of a renderer in a format without loss: grey next to a photo with colour, or of the photo's size and like it.
bool looks_like_pass(const std::filesystem::path& path, const std::filesystem::path& photo);
// Whether the file has an alpha channel that is not constant.
bool varying_alpha(const std::filesystem::path& path);
// The same picture as `photo`, without its background: transparent, or (`flat` is accepted) of one colour.
bool looks_like_cutout(const std::filesystem::path& path, const std::filesystem::path& photo, bool flat);
// Header data of a picture file.
struct PictureHead {
  PhotoFormat format = PhotoFormat::Unknown;
  double width = 0, height = 0;  // upright
  int orientation = 1;
  // PNG only: bits per sample, whether it has one channel, and whether it has an alpha channel.
  int bits = 0;
  bool grey = false, alpha = false;
};
PictureHead picture_head(const std::filesystem::path& path);
// Compares pictures across folders; caches file headers.
class CopyFinder {
 public:
  // `shrunk`: only the same picture reduced by a factor of 1.4 or more. Otherwise: nearly the same picture at any size (without
  // lens distortion, cropped at the border).
  bool looks_like_copy(const std::filesystem::path& copy, const std::filesystem::path& of, bool shrunk);

 private:
  const PictureHead& head(const std::filesystem::path& path);
  std::map<std::filesystem::path, PictureHead> heads_;
};

}  // namespace vitrine
