// The layers of a picture for people: on the contact sheet, with roles told by colour or grey, and as EXR files beside it.
#pragma once

#include <filesystem>
#include <vector>

#include "core/picture/view_picture.h"
#include "stages/evaluate/contact_sheet.h"

namespace vitrine {

// One cell per layer of `picture` except the surface (normal, depth), which the sheet shows anyway. Radiance times the view's
// gain, encoded; weights as grey, 1 = white.
std::vector<SheetCell> layer_cells(const ViewPicture& picture, const Vec3d& gain);

// eval/layers/<layer>/<stem>.exr
void write_layers(const std::filesystem::path& eval_folder, const View& view, const ViewPicture& picture);

}  // namespace vitrine
