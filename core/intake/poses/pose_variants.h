// Other readings of given poses: what a file means if it was written by other rules than those of its format. Whether one of them
// fits the photos better is for pose_agreement.h to measure; here is what they are, and how people say them.
//
// With A the axes of the format (camera frame from the file's camera frame: diag(1, -1, -1) for transforms.json, else identity)
// and G = cam_from_world as read, a file whose camera axes are L instead of A has the pose L A^-1 G, and L G^-1 if it was written
// the other way round. Left-handed frames mirror: then the world is mirrored too. A rigid motion of the world changes no picture,
// so no variant is about the world's axes.
#pragma once

#include <string>
#include <vector>

#include "core/intake/poses/pose_pixels.h"

namespace vitrine {

struct PoseVariant {
  std::string what;  // completes "the poses fit if ..."
  std::string hint;  // how to write them right
  ColmapModel model;
};

// The usual camera axes, each also inverted; of a COLMAP model the other order of the quaternion and the camera's centre as
// translation, too. The simplest first.
std::vector<PoseVariant> convention_variants(const ColmapModel& model, const PosePixels& pixels);
// The poses of other photos: shifted by one or two, in reverse, sorted as words where the photos count as numbers.
std::vector<PoseVariant> order_variants(const ColmapModel& model);
// The focal lengths of pictures of half, a quarter or an eighth of the size, and of as much larger ones.
std::vector<PoseVariant> focal_variants(const ColmapModel& model);

// Photos whose orientation is not settled, turned the other way. `pixels` follows.
ColmapModel turned_other_way(ColmapModel model, PosePixels& pixels);
// Cameras of a middle part of each photo at its size, instead of the whole photo at another size.
ColmapModel as_cropped(ColmapModel model, const PosePixels& pixels);

// How the format of the poses wants them, for hints.
std::string rule_of(PoseSource source);

}  // namespace vitrine
