// Camera axes of OpenGL (+x right, +y up, +z backward) against ours (+x right, +y down, +z forward).
#pragma once

#include "core/math/rigid.h"

namespace vitrine {

// Of a world-from-camera rotation; its own inverse.
inline Mat3d flipped_axes(Mat3d rotation) {
  rotation.c1 = -rotation.c1;
  rotation.c2 = -rotation.c2;
  return rotation;
}

}  // namespace vitrine
