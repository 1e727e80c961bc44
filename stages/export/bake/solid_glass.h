// Solid glass in an exported mesh (core/render/model/thick_glass.h) and its thickness. Its faces are those on the glass walls
// that refract rays; their vertices get the smooth normals of these walls, because refraction shows voxel steps. `thickness` is
// defined by glTF's KHR_materials_volume: distance along the inward normal to the other side.
#pragma once

#include <cstdint>
#include <vector>

#include "core/render/model/thick_glass.h"

namespace vitrine {

struct SolidGlass {
  float ior = 1.5f;
  std::vector<uint8_t> faces;    // [f] 1: on a glass wall
  std::vector<float> thickness;  // [v] scene units; 0 outside solid glass
  float greatest = 0;            // maximum thickness
};

// Replaces normals of `mesh`, which must have them.
SolidGlass find_solid_glass(TriMesh& mesh, const ThickGlass& glass);

// Faces of `content`, the mesh behind glass, that are outside the glass itself.
std::vector<uint8_t> outside_of(const ThickGlass& glass, const TriMesh& content);

}  // namespace vitrine
