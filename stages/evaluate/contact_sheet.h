// What a person looks at first: a few views as rows of photo, render, error, normals, depth and layers, with their names and
// figures.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/image/image.h"

namespace vitrine {

Image8 image8(const ImageF& srgb);  // clamp and round
// Mean absolute sRGB difference over the channels; black 0, through violet and orange to white = `white_at` and more.
Image8 error_picture(const ImageF& srgb, const ImageF& photo_srgb, double white_at);
Image8 normal_picture(const ImageF& normal);  // rgb = (n + 1) / 2, black = none
// Near bright, by inverse depth (there may be a sky); 2nd to 98th percentile; black = none.
Image8 depth_picture(const ImageF& zdepth);

struct SheetCell {
  std::string title;
  Image8 picture;
};
struct SheetRow {
  std::string label;  // "IMG_0007  24.31 DB"
  std::vector<SheetCell> cells;
};
// Five cells to a line; all get the size of the first picture, at most `cell_width` wide.
Image8 contact_sheet(std::span<const SheetRow> rows, int cell_width);

}  // namespace vitrine
