// ply-3dgs: the surfels as very flat ellipsoids, for the viewers and editors of 3D Gaussian splatting. A third scale of
// 1e-6 scene units makes the disk; colours become sRGB (display_color.h), which is what these programs show.
#include "stages/export/formats/display_color.h"
#include "stages/export/formats/format.h"
#include "stages/export/formats/gaussian_ply.h"

namespace vitrine {
namespace {

std::vector<std::string> write_ply_3dgs(ExportSource& source, const std::filesystem::path& folder) {
  const ExportFrame frame = source.frame();
  const std::string file = "gaussians_3dgs.ply";
  write_gaussian_ply(folder / file, in_frame(source.diffuse(), frame),
                     {.comments = source.header_lines({"vitrine_format 1", vertical_axis(frame), "color srgb_rec709"}),
                      .thickness = disk_thickness(frame),
                      .convert_color = encode_sh_for_display});
  return {file};
}

}  // namespace

ExportFormat ply_3dgs_format() {
  return {
      .name = "ply-3dgs",
      .summary = "surfels as flat ellipsoids for ordinary Gaussian splatting viewers, sRGB colour",
      .holds =
          "position, rotation, scales (the third is 1e-6 scene units), opacity and spherical harmonics of every diffuse surfel",
      .loses =
          "linear radiance: the mean colour of a surfel is encoded exactly, its view dependence to first order, values above 1 "
          "are kept but clipped on display; viewers blend in sRGB and project ellipsoids approximately, so edges and half "
          "transparent parts differ slightly; materials",
      .write = write_ply_3dgs};
}

}  // namespace vitrine
