// What a picture is by its pixels: does a file that is called like a mask, a depth map or a map of normals look like one? A
// photograph never does, so that a photo called carnival_mask.jpg stays one. A file that cannot be decoded looks like nothing.
#pragma once

#include <filesystem>
#include <map>

#include "core/scene/image/probe.h"

namespace vitrine {

struct MaskLook {
  bool both = false;   // there must be pixels of the class and others, as in no photo that is black or white all over
  bool alpha = true;   // an alpha channel of few levels makes a mask of a colour picture, too
  bool quick = false;  // a PNG of very few bytes counts without being decoded: for files whose names say that they are masks
};
// Few levels of grey, or few painted colours, or such an alpha channel.
bool looks_like_mask(const std::filesystem::path& path, const MaskLook& look = {});
// One channel, or three equal ones, beside a photo that has colour (or fewer bits).
bool looks_like_depth(const std::filesystem::path& path, const std::filesystem::path& photo);
// Colours that are unit vectors, 2 c - 1, or no colour at all.
bool looks_like_normals(const std::filesystem::path& path);
// What the beginning of a file says of its picture.
struct PictureHead {
  PhotoFormat format = PhotoFormat::Unknown;
  double width = 0, height = 0;  // upright
  int orientation = 1;
  // Of a PNG: bits per sample, and whether it has one channel.
  int bits = 0;
  bool grey = false;
};
// Compares pictures of many folders with each other; the head of each file is read once.
class CopyFinder {
 public:
  // `shrunk`: the same picture with fewer pixels, by a factor of 1.4 or more, and nothing else. Otherwise: much the same picture
  // at any size (without the lens's distortion, cut at the border).
  bool looks_like_copy(const std::filesystem::path& copy, const std::filesystem::path& of, bool shrunk);

 private:
  const PictureHead& head(const std::filesystem::path& path);
  std::map<std::filesystem::path, PictureHead> heads_;
};

}  // namespace vitrine
