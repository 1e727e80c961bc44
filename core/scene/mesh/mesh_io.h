// Triangle meshes as files: binary little-endian PLY (vertex normals, 8-bit sRGB colours, object_id). The reader takes ASCII and
// binary PLY, polygons are fanned; it checks every count against the file size before it allocates.
#pragma once

#include <filesystem>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

void write_mesh_ply(const std::filesystem::path& path, const TriMesh& mesh);
TriMesh read_mesh_ply(const std::filesystem::path& path);

}  // namespace vitrine
