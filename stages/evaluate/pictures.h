// Pictures for people: errors, normals, depth, and the layers of a picture, as cells of the contact sheet and as EXR files.
#pragma once

#include <filesystem>

#include "core/image/contact_sheet.h"
#include "core/picture/view_picture.h"

namespace vitrine {

// Mean absolute sRGB difference over the channels; black 0, through violet and orange to white = 0.25 and more.
Image8 error_picture(const ImageF& srgb, const ImageF& photo_srgb);
Image8 normal_picture(const ImageF& normal);  // rgb = (n + 1) / 2, black = none
// Near bright, by inverse depth (there may be a sky); 2nd to 98th percentile; black = none.
Image8 depth_picture(const ImageF& zdepth);

// One cell per layer of `picture` except the surface (normal, depth), which the sheet shows anyway. Radiance times the view's
// gain, encoded; weights as grey, 1 = white.
void add_layers(const ViewPicture& picture, const Vec3d& gain, ContactSheet& sheet);
// eval/layers/<layer>/<stem>.exr
void write_layers(const std::filesystem::path& eval_folder, const View& view, const ViewPicture& picture);

}  // namespace vitrine
