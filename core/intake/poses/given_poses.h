// Reads user-supplied camera poses: a COLMAP model (bin or txt), a transforms.json, files of Metashape, OpenSfM or OpenMVG, or a
// folder of 3x4 projection matrices.
// pose_files.h selects the file and resolves photo names. Cameras are scaled to the ingested photo size.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/intake/photos/photo_list.h"
#include "core/intake/poses/pose_pixels.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine {

// P ~ K [R | t]. Throws Error{Input} (naming `where`) when P is singular or has a skew that a pinhole camera cannot represent.
struct Decomposed {
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Rigid cam_from_world;
};
Decomposed decomposed_projection(const double (&p)[12], const std::filesystem::path& where);

struct GivenPoses {
  std::filesystem::path source;        // the file or folder read: of a COLMAP model, a JSON or XML file, of matrices
  ColmapModel model;                   // image names are photo names; points and observations where the source has them
  std::vector<size_t> other_versions;  // photos without a pose that are another version of a posed photo ("images_4/a.jpg")
  PosePixels pixels;                   // pixel convention of the poses; has notes of its own
  Notes notes;
};
// `path`: file or folder. `matrix_scale`: factor of the first two rows of projection matrices; 0 = estimated from the principal
// point. Cameras and poses of the result are those of the upright photos; `pixels` reports the conversion and the assumptions
// made. Throws Error{Input}.
GivenPoses given_poses(const std::filesystem::path& path, std::span<const Photo> photos, double matrix_scale);
ColmapModel read_given_poses(const std::filesystem::path& path, std::span<const Photo> photos, double matrix_scale,
                             PosePixels* pixels = nullptr);

}  // namespace vitrine
