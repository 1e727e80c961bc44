// Helpers shared by the readers and the writer of transforms.json and camera paths. For *.cpp files of this module only.
#pragma once

#include "core/foundation/config/json_file.h"
#include "core/foundation/math/rigid.h"

namespace vitrine {

inline constexpr const char* kTransformsFormat = "transforms.json";

// Upper three rows of a 4x4 (or 3x4) matrix. For use inside read_json_file.
Similarity similarity_of(const JsonAt& rows);

// Converts a world-from-camera rotation between OpenGL camera axes (+x right, +y up, +z backward) and ours (+x right, +y down,
// +z forward), in both directions.
inline Mat3d flipped_axes(Mat3d rotation) {
  rotation.c1 = -rotation.c1;
  rotation.c2 = -rotation.c2;
  return rotation;
}

}  // namespace vitrine
