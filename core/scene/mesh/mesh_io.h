// Triangle mesh files: writes binary little-endian PLY (vertex normals, 8-bit sRGB colours, object_id). Reads ASCII and binary
// PLY; polygons are split into triangle fans. Every count is checked against the file size before allocation.
#pragma once

#include <filesystem>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

void write_mesh_ply(const std::filesystem::path& path, const TriMesh& mesh);
TriMesh read_mesh_ply(const std::filesystem::path& path);

}  // namespace vitrine
