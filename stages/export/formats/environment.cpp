// environment: the light that the decompose stage found, as lat-long EXR of linear radiance. The scene's orientation: first row =
// +z, centre = +x, counter-clockwise seen from above towards the left (core/light/environment.h). Needs the decompose stage;
// without it there is no file.
#include "core/base/file.h"
#include "core/picture/decomposed_materials.h"
#include "stages/export/formats/format.h"

namespace vitrine {
namespace {

std::vector<std::string> write_environment(ExportSource& source, const std::filesystem::path& folder) {
  if (!source.decompose()) return {};
  const std::string file = "environment.exr";
  link_or_copy(decomposed_environment_path(*source.decompose()), folder / file);
  return {file};
}

}  // namespace

ExportFormat environment_format() {
  return {.name = "environment",
          .summary = "the light of the photos as lat-long EXR (when the decompose stage ran)",
          .holds = "linear radiance in the units of the albedo, up = first row, +x of the scene in the centre",
          .loses = "light that is near: everything is infinitely far away; the axes option does not turn it",
          .write = write_environment};
}

}  // namespace vitrine
