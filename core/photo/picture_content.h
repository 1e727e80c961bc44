// What a picture is by its pixels: does a file that is called like a mask, a depth map or a map of normals look like one? A
// photograph never does, so that a photo called carnival_mask.jpg stays one. A file that cannot be decoded looks like nothing.
#pragma once

#include <filesystem>

namespace vitrine {

// Few levels of grey (or painted colours), or an alpha channel of few levels. `both`: there must be pixels of the class and
// others, as in no photo that is black or white all over.
bool looks_like_mask(const std::filesystem::path& path, bool both = false);
// One channel, or three equal ones, beside a photo that has colour (or fewer bits).
bool looks_like_depth(const std::filesystem::path& path, const std::filesystem::path& photo);
// Colours that are unit vectors, 2 c - 1, or no colour at all.
bool looks_like_normals(const std::filesystem::path& path);
// `shrunk`: the same picture with fewer pixels, by a factor of 1.4 or more, and nothing else. Otherwise: much the same picture at
// any size (without the lens's distortion, cut at the border).
bool looks_like_copy(const std::filesystem::path& copy, const std::filesystem::path& of, bool shrunk);

}  // namespace vitrine
