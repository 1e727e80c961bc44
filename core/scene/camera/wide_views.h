// Pinhole views cut from the photos of wide lenses. All views of one photo have one centre and known rotations; later stages
// treat them as views of a rig, like those of panoramas (panorama_views.h).
//
// A fisheye photo is cut along the faces of a cube around the camera, the first of which looks along the axis of the lens. A face
// reaches a little beyond 45 degrees to each side, is cropped to the pixels that the lens shows, and is left out if it shows next
// to nothing. A lens of 180 degrees thus gives one view of 90 x 90 degrees and four of half its size.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/scene/camera/undistort.h"

namespace vitrine {

// Of fisheye lenses (colmap_lens.h), degrees across the width or the height: wider photos are cut.
inline constexpr double kWidestPicture_deg = 105;

// Degrees that the photo shows across its width or its height, whichever is more. `circle_px`: see Undistortion.
double widest_field_deg(const ColmapCamera& camera, double circle_px = 0);

// Views of the photos of this camera: undistortion(camera) alone up to kWidestPicture_deg, else the faces, with as many pixels a
// degree in the middle of a face as the photo has at its axis.
std::vector<Undistortion> lens_views(const ColmapCamera& camera, double circle_px = 0);

// 1 where a cut view shows nothing, else 0: [1] of the size of the view. Empty if it is seen everywhere.
ImageF unseen_pixels(const Undistortion& view);

// "IMG_1/view_02.jpg" of the photo "IMG_1.jpg"; `folder`: of view_folders().
std::string view_name(const std::string& folder, const std::string& photo, size_t view);
// Folder of the views of each photo if it is cut: its stem, with '_' appended until no photo lies in it.
std::vector<std::string> view_folders(std::span<const std::string> stems);

}  // namespace vitrine
