// Indexed triangle mesh. Faces are counter-clockwise seen from outside. Attributes are empty or have one value per vertex.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

struct TriMesh {
  std::vector<Vec3f> positions;                // [v]
  std::vector<Vec3f> normals;                  // [v] or empty, unit
  std::vector<Vec3f> colors;                   // [v] or empty, linear RGB
  std::vector<std::array<uint32_t, 3>> faces;  // [f]
  std::vector<uint16_t> object_ids = {};       // [v] or empty; ids of the object table (core/scene/objects), 0 = none

  // Object id shared by at least two corners of the face, else 0.
  uint16_t object_of_face(size_t f) const {
    if (object_ids.empty()) return 0;
    const uint16_t a = object_ids[faces[f][0]], b = object_ids[faces[f][1]], c = object_ids[faces[f][2]];
    return a == b || a == c ? a : b == c ? b : uint16_t(0);
  }
};

}  // namespace vitrine
