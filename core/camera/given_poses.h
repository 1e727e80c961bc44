// Poses from the user instead of from matching: a COLMAP model (bin or txt), a transforms.json, or a folder of 3x4 projection
// matrices. Cameras are scaled to the size at which the photos were ingested; photos are found by name, by path below the photo
// folder, by file name, or by stem, whichever is unique.
#pragma once

#include <filesystem>
#include <span>

#include "core/camera/colmap_model.h"
#include "core/camera/photo_list.h"
#include "core/camera/pose_pixels.h"

namespace vitrine {

// P ~ K [R | t]. Throws Error{Input} (naming `where`) when P is singular, or has a skew that a pinhole camera cannot carry.
struct Decomposed {
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Rigid cam_from_world;
};
Decomposed decomposed_projection(const double (&p)[12], const std::filesystem::path& where);

// `path`: file or folder. `matrix_scale`: factor of the first two rows of projection matrices; 0 = found from the principal
// point. Image names of the result are photo names. Points and observations are kept when the source has them. Cameras and poses
// of the result are those of the upright photos; `pixels` (optional) tells what that took and what was assumed (pose_pixels.h).
ColmapModel read_given_poses(const std::filesystem::path& path, std::span<const Photo> photos, double matrix_scale,
                             PosePixels* pixels = nullptr);

}  // namespace vitrine
