// mesh-ply: the cleaned mesh, binary PLY with vertex normals and 8-bit sRGB colours.
#include "core/mesh/mesh_io.h"
#include "stages/export/formats/format.h"

namespace vitrine {
namespace {

std::vector<std::string> write(ExportSource& source, const std::filesystem::path& folder) {
  const std::string file = "mesh.ply";
  write_mesh_ply(folder / file, source.mesh());
  return {file};
}

}  // namespace

ExportFormat mesh_ply_format() {
  return {.name = "mesh-ply",
          .summary = "the mesh as binary PLY",
          .holds = "triangles, vertex normals, vertex colours (8-bit sRGB)",
          .loses = "view dependence, colours above 1, materials",
          .write = write};
}

}  // namespace vitrine
