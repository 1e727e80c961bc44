// ply-2dgs: the surfels as they are, in the layout of 2D Gaussian splatting: two scales, the disk normal is the third column of
// the rotation. Colours stay linear Rec.709, so that nothing is rounded away; the header says so.
#include "stages/export/formats/format.h"
#include "stages/export/formats/gaussian_ply.h"

namespace vitrine {
namespace {

std::vector<std::string> write_ply_2dgs(ExportSource& source, const std::filesystem::path& folder) {
  const ExportFrame frame = source.frame();
  const std::string file = "gaussians_2dgs.ply";
  write_gaussian_ply(
      folder / file, in_frame(source.diffuse(), frame),
      {.comments = source.header_lines({"vitrine_format 1", "SplatRenderMode: 2dgs", vertical_axis(frame), "color lin_rec709"}),
       .disk_normals = true});
  return {file};
}

}  // namespace

ExportFormat ply_2dgs_format() {
  return {
      .name = "ply-2dgs",
      .summary = "surfels for 2D Gaussian splatting programs, linear colour",
      .holds =
          "position, rotation, two scales, opacity and spherical harmonics of every diffuse surfel, bit for bit; disk normals",
      .loses =
          "materials (f0, roughness, specular weight, transmission); programs that take colours as sRGB show the linear ones "
          "too dark: use ply-3dgs to look at the scene",
      .write = write_ply_2dgs};
}

}  // namespace vitrine
