// Which parts of an exported mesh bound solid glass (core/render/model/thick_glass.h), and how thick it is below them. Faces are those
// that lie on the shell that rays bend at; their vertices get its smooth normals, since refraction shows every step of a voxel.
// `thickness` is what glTF's KHR_materials_volume asks for: from a place straight down to the other side.
#pragma once

#include <cstdint>
#include <vector>

#include "core/render/model/thick_glass.h"

namespace vitrine {

struct SolidGlass {
  float ior = 1.5f;
  std::vector<uint8_t> faces;    // [f] 1: part of a shell
  std::vector<float> thickness;  // [v] scene units; 0 off the shells
  float greatest = 0;            // thickness
};

// Changes normals of `mesh`, which must have them.
SolidGlass find_solid_glass(TriMesh& mesh, const ThickGlass& glass);

// Faces of `content`, what stands behind glass, that are not in the glass itself.
std::vector<uint8_t> outside_of(const ThickGlass& glass, const TriMesh& content);

}  // namespace vitrine
