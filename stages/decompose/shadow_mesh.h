// The mesh as light meets it.
#pragma once

#include <filesystem>
#include <vector>

#include "core/mesh/tri_mesh.h"
#include "stages/decompose/lit_points.h"

namespace vitrine {

// mesh/mesh.ply of a mesh artifact. Throws Error{Input} where it has no area or no colours.
TriMesh read_shadow_mesh(const std::filesystem::path& folder);
double area_of(const TriMesh& mesh);
// Per vertex, of the nearest surface point; `voxel`: of the points.
std::vector<float> transmission_of(const TriMesh& mesh, const std::vector<LitPoint>& points, double voxel);

}  // namespace vitrine
