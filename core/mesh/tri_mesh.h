// An indexed triangle mesh. Faces are counter-clockwise seen from outside. Attributes are empty or one per vertex.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math/vec.h"

namespace vitrine {

struct TriMesh {
  std::vector<Vec3f> positions;                // [v]
  std::vector<Vec3f> normals;                  // [v] or empty, unit
  std::vector<Vec3f> colors;                   // [v] or empty, linear RGB
  std::vector<std::array<uint32_t, 3>> faces;  // [f]
};

}  // namespace vitrine
