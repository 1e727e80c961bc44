// preview-3dgs: all layers in one Gaussian scene for ordinary viewers. The other layers are not merged in: what mirrors show lies
// at mirrored places and would be seen from everywhere. Instead the opaque twin of the scene, or its diffuse layer, takes on the
// colours of the composed pictures (bake/preview_fit.h).
#include "stages/export/formats/format.h"
#include "stages/export/formats/gaussian_ply.h"

namespace vitrine {
namespace {

std::vector<std::string> write_preview_3dgs(ExportSource& source, const std::filesystem::path& folder) {
  const std::string file = "preview_3dgs.ply";
  const ExportFrame frame = source.frame();
  write_gaussian_ply(folder / file, in_frame(source.preview(), frame),
                     {.comments = source.header_lines({"vitrine_format 1", vertical_axis(frame), "color srgb_rec709"}),
                      .thickness = disk_thickness(frame)});
  return {file};
}

}  // namespace

ExportFormat preview_3dgs_format() {
  return {
      .name = "preview-3dgs",
      .summary = "what all layers show together, as one 3D Gaussian scene, sRGB colour",
      .holds =
          "the opaque twin of the scene, or its diffuse layer, as flat ellipsoids with spherical harmonics fitted to the "
          "composed pictures: "
          "reflections and what glass shows are surfels like all others",
      .loses =
          "the layers; what glass and mirrors show follows the eye only as far as surfels behind their surfaces and spherical "
          "harmonics can; linear radiance; materials",
      .write = write_preview_3dgs};
}

}  // namespace vitrine
