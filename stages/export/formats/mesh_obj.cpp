// mesh-obj: the cleaned mesh as Wavefront OBJ text, colours as the common six-number vertex lines.
#include "core/mesh/mesh_io.h"
#include "stages/export/formats/format.h"

namespace vitrine {
namespace {

std::vector<std::string> write(ExportSource& source, const std::filesystem::path& folder) {
  const std::string file = "mesh.obj";
  write_mesh_obj(folder / file, source.mesh());
  return {file};
}

}  // namespace

ExportFormat mesh_obj_format() {
  return {.name = "mesh-obj",
          .summary = "the mesh as OBJ text",
          .holds = "triangles, vertex normals, vertex colours (for readers that know the six-number vertex line)",
          .loses = "view dependence, colours above 1, materials; large and slow to read compared with PLY",
          .write = write};
}

}  // namespace vitrine
