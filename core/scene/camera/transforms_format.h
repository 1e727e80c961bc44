// What the readers and the writer of transforms.json and of camera paths share. For *.cpp files of this module only.
#pragma once

#include "core/foundation/config/json_file.h"
#include "core/foundation/math/rigid.h"

namespace vitrine {

inline constexpr const char* kTransformsFormat = "transforms.json";

// The upper three rows of a 4x4 (or 3x4) matrix. For use inside read_json_file.
Similarity similarity_of(const JsonAt& rows);

// A world-from-camera rotation with camera axes of OpenGL (+x right, +y up, +z backward) for one with ours (+x right, +y down, +z
// forward), and the other way round.
inline Mat3d flipped_axes(Mat3d rotation) {
  rotation.c1 = -rotation.c1;
  rotation.c2 = -rotation.c2;
  return rotation;
}

}  // namespace vitrine
