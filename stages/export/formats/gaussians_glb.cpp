// Export format gaussians-glb: the merged preview (preview-3dgs) as glTF with KHR_gaussian_splatting. A point primitive with the
// attributes
//   POSITION, KHR_gaussian_splatting:ROTATION (x y z w), :SCALE (linear), :OPACITY (0 to 1), :SH_DEGREE_l_COEF_n (vec3)
// and COLOR_0, decoded to linear values, for viewers that show only points. The extension is ratified (KhronosGroup/glTF,
// extensions/2.0/Khronos/KHR_gaussian_splatting): kernel and colorSpace are required, unit quaternions, scales not below zero,
// degrees of spherical harmonics complete. Drafts before February 2026 had logarithms of scales.
#include <algorithm>
#include <cmath>

#include "core/foundation/math/color.h"
#include "core/scene/surfels/activation.h"
#include "stages/export/formats/gaussian_ply.h"
#include "stages/export/formats/glb_file.h"
#include "stages/export/formats/source.h"

namespace vitrine {
namespace {

std::vector<std::string> write_gaussians_glb(ExportSource& source, const std::filesystem::path& folder) {
  const std::string file = "gaussians.glb";
  const ExportFrame frame = source.frame(ExportAxes::Rhyu);
  const SplatLayer layer = in_frame(source.preview(), frame);
  const size_t n = layer.size();
  std::vector<Vec3f> positions(n), scales(n);
  std::vector<std::array<float, 4>> rotations(n), colors(n);
  std::vector<float> opacities(n);
  for (size_t i = 0; i < n; ++i) {
    const float* mean = layer.at(Attribute::Mean, i);
    positions[i] = {mean[0], mean[1], mean[2]};
    const float* q = layer.at(Attribute::Rotation, i);
    const Quatf unit = normalized(Quatf{q[0], q[1], q[2], q[3]});
    rotations[i] = {unit.x, unit.y, unit.z, unit.w};
    const float* s = layer.at(Attribute::LogScale, i);
    scales[i] = {std::exp(s[0]), std::exp(s[1]), disk_thickness(frame)};
    opacities[i] = sigmoid(*layer.at(Attribute::Opacity, i));
    // glTF vertex colours are linear.
    for (size_t c = 0; c < 3; ++c)
      colors[i][c] = linear_from_srgb(std::clamp(0.5f + kShDc * layer.at(Attribute::ShDc, i)[c], 0.f, 1.f));
    colors[i][3] = opacities[i];
  }
  GlbFile glb("vitrine");
  if (source.place()) glb.add_place(*source.place());
  glb.use_extension("KHR_gaussian_splatting");
  glb.json["scenes"] = {{{"nodes", {0}}}};
  glb.json["nodes"] = {{{"name", "gaussians"}, {"mesh", 0}}};
  GlbFile::Json attributes = {{"POSITION", glb.add(positions, true)},
                              {"COLOR_0", glb.add(colors)},
                              {"KHR_gaussian_splatting:ROTATION", glb.add(rotations)},
                              {"KHR_gaussian_splatting:SCALE", glb.add(scales)},
                              {"KHR_gaussian_splatting:OPACITY", glb.add(opacities)}};
  for (int l = 0; l <= layer.sh_degree(); ++l)
    for (int m = 0; m <= 2 * l; ++m) {
      const size_t k = size_t(l * l + m);
      std::vector<Vec3f> values(n);
      for (size_t i = 0; i < n; ++i) {
        const float* h = k == 0 ? layer.at(Attribute::ShDc, i) : layer.at(Attribute::ShRest, i) + 3 * (k - 1);
        values[i] = {h[0], h[1], h[2]};
      }
      attributes[fmt::format("KHR_gaussian_splatting:SH_DEGREE_{}_COEF_{}", l, m)] = glb.add(values);
    }
  const GlbFile::Json extension = {{"kernel", "ellipse"},
                                   {"colorSpace", "srgb_rec709_display"},
                                   {"sortingMethod", "cameraDistance"},
                                   {"projection", "perspective"}};
  glb.json["meshes"] = {
      {{"primitives", {{{"attributes", attributes}, {"mode", 0}, {"extensions", {{"KHR_gaussian_splatting", extension}}}}}}}};
  glb.write(folder / file);
  return {file};
}

}  // namespace

ExportFormat gaussians_glb_format() {
  return {
      .name = "gaussians-glb",
      .summary = "the merged preview as glTF with the ratified extension KHR_gaussian_splatting, +Y up",
      .holds =
          "what preview-3dgs holds, with spherical harmonics of the trained degree; points with colours for viewers without the "
          "extension",
      .loses = "what preview-3dgs loses; the extension has no flat kernel (the third scale is 1e-6 scene units)",
      .write = write_gaussians_glb};
}

}  // namespace vitrine
