// Classifies a picture in a photo folder by its name: mask, map (depth, normals, confidence, labels, render pass), cut-out or
// reduced copy of a photo. Users and programs store these next to the photos, or in a folder next to theirs:
//
//   b_mask.png  b.jpg_mask.png  b.mask.png  mask_b.png  dynamic_mask_b.png  b_seg.png  b_alpha.png  b.jpg.png   masks/b.png
//   masks_2/b.png b_depth.png  b_depth_0001.png  depth_b.exr     depth/b.png      b_normal.png  normals/b.png      b_thumb.jpg
//   b_conf.png  confidence/b.png  b_labels.png  b-removebg-preview.png  b_nobg.png
//
// and next to photos with a role in their own name: 7_rgb.png and 7_mask.png, frame_7.color.png and frame_7.depth.png; with or
// without separators: Image0001.jpg and Depth0001.png, frame_00007.jpg and conf_00007.png, cam0_rgb_7.png and cam0_depth_7.png.
// Uses only the name. picture_content.h checks the content, sorted_pictures.cpp the existence of "b".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

enum class PictureRole : unsigned char { Mask, Cutout, Depth, Normals, Confidence, Labels, Pass, Copy };
inline constexpr PictureRole kPictureRoles[] = {PictureRole::Mask,    PictureRole::Cutout,     PictureRole::Depth,
                                                PictureRole::Normals, PictureRole::Confidence, PictureRole::Labels,
                                                PictureRole::Pass,    PictureRole::Copy};
std::string_view singular(PictureRole role);  // "a mask", "a depth map", ...
std::string_view plural(PictureRole role);    // "masks", "depth maps", ...

struct NamedRole {
  PictureRole role = PictureRole::Mask;
  std::string of;  // the picture it belongs to: "b", or "b.jpg" where the name includes its extension
};
// All readings of a file name without its extension, the likeliest first. Keeps letter case.
std::vector<NamedRole> roles_of_stem(const std::string& stem);
// The words and numbers of a stem, in lower case, without role words and without words that only name a picture:
//   conf_00007 -> {Confidence, "7", "7"}   Image0007 -> {none, "7", "7"}   cam0_depth_0007 -> {Depth, "cam 0 7", "7"}
// Words end at separators, digits and capital letters.
struct StemKey {
  std::optional<PictureRole> role;
  std::string rest, number;  // what remains; its last number, without leading zeros
};
StemKey key_of_stem(std::string_view stem);
// "b_rgb", "color_b", "b" ...: possible stems of the photo of "b", in lower case, the likeliest first.
std::vector<std::string> photo_stems_of(std::string_view of);
// "masks", "Masks_2", "depth_maps", ...
std::optional<PictureRole> role_of_folder(std::string_view name);
// "object", "transparent", "glass", ...: possibly a folder of masks.
bool is_class_folder(std::string_view name);
// "depth_0001" -> "depth", "masks_2" -> "masks"; an all-digit name is unchanged.
std::string_view without_number(std::string_view text);
// Whether "b.jpg" ends with a photo extension: letters and digits, at most four, at least one letter (not "v1.25").
bool has_photo_extension(const std::string& name);

}  // namespace vitrine
