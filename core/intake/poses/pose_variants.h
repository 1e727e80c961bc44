// Alternative conventions of given poses: what a file means if it was written by other rules than those of its format.
// pose_agreement.h measures which one fits the photos; this file lists the variants and their user-facing descriptions.
//
// With A the axes of the format (camera frame from the file's camera frame: diag(1, -1, -1) for transforms.json, else identity)
// and G = cam_from_world as read, a file whose camera axes are L instead of A has the pose L A^-1 G, and L G^-1 if it stores the
// inverse. Left-handed frames mirror: then the world is mirrored too. A rigid motion of the world changes no picture, so no
// variant changes the world's axes.
#pragma once

#include <string>
#include <vector>

#include "core/intake/poses/pose_pixels.h"

namespace vitrine {

struct PoseVariant {
  std::string what;  // completes "the poses fit if ..."
  std::string hint;  // how to write them correctly
  ColmapModel model;
};

// The usual camera axes, each also inverted; poses of which the rotation or the translation alone is inverted (R^T with C or t,
// R with C); for a COLMAP model also the other quaternion order. The simplest first.
std::vector<PoseVariant> convention_variants(const ColmapModel& model, const PosePixels& pixels);
// Poses assigned to other photos: shifted by one or two, reversed, or sorted as text where the photos are sorted as numbers.
std::vector<PoseVariant> order_variants(const ColmapModel& model);
// Normalised intrinsics; focal lengths for pictures of 1/2, 1/4 or 1/8 of the size, and of 2, 4 or 8 times the size.
std::vector<PoseVariant> focal_variants(const ColmapModel& model, const PosePixels& pixels);

// Rotates the photos whose orientation is not settled the other way, and updates `pixels`.
ColmapModel turned_other_way(ColmapModel model, PosePixels& pixels);
// Treats the cameras as those of a central crop of each photo instead of the resized photo.
ColmapModel as_cropped(ColmapModel model, const PosePixels& pixels);

// The pose convention of the format, for hints.
std::string rule_of(PoseSource source);

}  // namespace vitrine
