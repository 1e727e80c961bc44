// What a picture in a folder of photos is by its name, where it is no photo itself: a mask, a depth map, a map of normals or a
// reduced copy of another one. People and programs leave these beside the photos, or in a folder beside theirs:
//
//   b_mask.png  b.jpg_mask.png  b.mask.png  mask_b.png  dynamic_mask_b.png  b_seg.png  b_alpha.png  b.jpg.png   masks/b.png
//   masks_2/b.png b_depth.png  b_depth_0001.png  depth_b.exr     depth/b.png      b_normal.png  normals/b.png      b_thumb.jpg
//
// and beside photos that say what they are, too: 7_rgb.png and 7_mask.png, frame_7.color.png and frame_7.depth.png.
// Only the name is read here. Whether the content agrees: picture_content.h; whether there is a "b": photo_files.cpp.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

enum class PictureRole : unsigned char { Mask, Depth, Normals, Copy };
std::string_view plural(PictureRole role);  // "masks", "depth maps", ...

struct NamedRole {
  PictureRole role = PictureRole::Mask;
  std::string of;  // what the picture belongs to: "b", or "b.jpg" where its own extension is part of the name
};
// Of a file name without its extension: every way to read it, the likeliest first. Letter case is kept.
std::vector<NamedRole> roles_of_stem(const std::string& stem);
// "b_rgb", "color_b", "b" ...: how a photo that belongs to "b" may be called, in lower case, the likeliest first.
std::vector<std::string> photo_stems_of(std::string_view of);
// "masks", "Masks_2", "depth_maps", ...
std::optional<PictureRole> role_of_folder(std::string_view name);
// "object", "transparent", "glass", ...: a folder of masks, perhaps.
bool is_class_folder(std::string_view name);
// "depth_0001" -> "depth", "masks_2" -> "masks"; a name of digits alone stays.
std::string_view without_number(std::string_view text);
// The photo's own extension at the end of "b.jpg": letters and digits, at most four, at least one letter (not "v1.25").
bool has_photo_extension(const std::string& name);

}  // namespace vitrine
