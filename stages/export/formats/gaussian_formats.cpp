// Surfel export formats in the PLY layout of Gaussian splatting.
#include "core/foundation/math/color.h"
#include "core/scene/surfels/activation.h"
#include "stages/export/formats/gaussian_ply.h"
#include "stages/export/formats/source.h"

namespace vitrine {

namespace {

constexpr float kNormalReach = 3;  // mean edges of the mesh: largest distance of surfels on the mesh

// ply-2dgs: the surfels in the layout of 2D Gaussian splatting: two scales, the disk normal is the third column of the rotation.
// Colours stay linear Rec.709 without loss; the header contains this.
std::vector<std::string> write_ply_2dgs(ExportSource& source, const std::filesystem::path& folder) {
  const ExportFrame frame = source.frame();
  const std::string file = "gaussians_2dgs.ply";
  write_gaussian_ply(
      folder / file, in_frame(source.diffuse(), frame),
      {.comments = source.header_lines({"vitrine_format 1", "SplatRenderMode: 2dgs", vertical_axis(frame), "color lin_rec709"}),
       .disk_normals = true,
       .least_degree = kSplatFileDegree});
  return {file};
}

// ply-3dgs: the surfels as very flat ellipsoids, for viewers and editors of 3D Gaussian splatting. The third scale is 1e-6 scene
// units; colours become sRGB (encode_sh_for_display), as these programs expect.
std::vector<std::string> write_ply_3dgs(ExportSource& source, const std::filesystem::path& folder) {
  const ExportFrame frame = source.frame();
  const std::string file = "gaussians_3dgs.ply";
  write_gaussian_ply(folder / file, in_frame(source.diffuse(), frame),
                     {.comments = source.header_lines({"vitrine_format 1", vertical_axis(frame), "color srgb_rec709"}),
                      .thickness = disk_thickness(frame),
                      .least_degree = kSplatFileDegree,
                      .convert_color = encode_sh_for_display});
  return {file};
}

// ply-albedo: the surfels as in ply-3dgs, for programs that light splats. Their colour is the albedo of the decompose stage,
// without view dependence; normals face outwards; the materials follow the standard properties:
//   roughness  f0_r f0_g f0_b  specular_weight  transmission      linear, 0 to 1 (core/render/picture/decomposed_materials.h)
//   confidence      0 to 1 (core/render/picture/confidence.h), if it could be measured
// Colours are sRGB as in all files of this layout. Surfels that represent the captured light are omitted.
std::vector<std::string> write_ply_albedo(ExportSource& source, const std::filesystem::path& folder) {
  const DecomposedMaterials& found = source.decomposed();
  const SplatLayer& diffuse = source.diffuse();
  std::vector<uint32_t> kept;
  for (uint32_t i = 0; i < diffuse.size(); ++i)
    if (!found.shows_sky(i)) kept.push_back(i);
  SplatLayer layer(LayerKind::Diffuse, 0, kept.size());
  if (const auto ids = diffuse.object_ids(); !ids.empty()) {
    std::vector<uint16_t> of_kept;
    for (const uint32_t i : kept) of_kept.push_back(ids[i]);
    layer.set_object_ids(std::move(of_kept));
  }
  std::vector<MoreProperty> more{{"roughness", {}},       {"f0_r", {}},        {"f0_g", {}}, {"f0_b", {}},
                                 {"specular_weight", {}}, {"transmission", {}}};
  const std::span<const float> confidence = source.confidence();
  if (!confidence.empty()) more.push_back({"confidence", {}});
  for (size_t to = 0; to < kept.size(); ++to) {
    const uint32_t i = kept[to];
    for (const Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity})
      std::copy_n(diffuse.at(a, i), diffuse.width(a), layer.at(a, to));
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::ShDc, to)[c] = (srgb_from_linear(found.albedo[i][c]) - 0.5f) / kShDc;
    const float values[] = {found.roughness[i],
                            found.f0[i].x,
                            found.f0[i].y,
                            found.f0[i].z,
                            found.specular_weight[i],
                            found.transmission[i],
                            confidence.empty() ? 0 : confidence[i]};
    for (size_t k = 0; k < more.size(); ++k) more[k].values.push_back(values[k]);
  }
  const ExportFrame frame = source.frame();
  std::vector<Vec3f> normals = outward_normals(layer, source.mesh(), kNormalReach * float(mean_edge_length(source.mesh())));
  for (Vec3f& n : normals) n = frame.direction(n);
  if (kept.size() < diffuse.size())
    source.add_note(fmt::format("{} surfels show the light of the photos and are left out", diffuse.size() - kept.size()));
  const std::string file = "gaussians_albedo.ply";
  write_gaussian_ply(
      folder / file, in_frame(layer, frame),
      {.comments = source.header_lines({"vitrine_format 1", vertical_axis(frame), "color srgb_rec709", "color is albedo"}),
       .normals = normals,
       .more = more,
       .thickness = disk_thickness(frame)});
  return {file};
}

// preview-3dgs: all layers in one Gaussian scene for ordinary viewers. The other layers are not merged in, because surfels of
// reflections are at virtual positions and would be visible from everywhere. Instead the opaque twin, or the diffuse layer, gets
// the colours of the composed pictures (bake/preview_fit.h).
std::vector<std::string> write_preview_3dgs(ExportSource& source, const std::filesystem::path& folder) {
  const std::string file = "preview_3dgs.ply";
  const ExportFrame frame = source.frame();
  write_gaussian_ply(folder / file, in_frame(source.preview(), frame),
                     {.comments = source.header_lines({"vitrine_format 1", vertical_axis(frame), "color srgb_rec709"}),
                      .thickness = disk_thickness(frame),
                      .least_degree = kSplatFileDegree});
  return {file};
}

}  // namespace

ExportFormat ply_2dgs_format() {
  return {.name = "ply-2dgs",
          .summary = "surfels for 2D Gaussian splatting programs, linear colour",
          .holds =
              "position, rotation, two scales, opacity and spherical harmonics of every diffuse surfel, bit for bit, padded with "
              "zeros to degree 3 (45 f_rest, 244 bytes a surfel); disk normals",
          .loses =
              "materials (f0, roughness, specular weight, transmission); programs that take colours as sRGB show the linear ones "
              "too dark: use ply-3dgs to look at the scene",
          .write = write_ply_2dgs};
}

ExportFormat ply_3dgs_format() {
  return {
      .name = "ply-3dgs",
      .summary = "surfels as flat ellipsoids for ordinary Gaussian splatting viewers, sRGB colour",
      .holds =
          "position, rotation, scales (the third is 1e-6 scene units), opacity and spherical harmonics of every diffuse surfel, "
          "padded with zeros to degree 3: 45 f_rest, 248 bytes a surfel, as many importers require; 4 bytes more where the scene "
          "has objects (object_id)",
      .loses =
          "linear radiance: the mean colour of a surfel is encoded exactly, its view dependence to first order, values above 1 "
          "are kept but clipped on display; viewers blend in sRGB and project ellipsoids approximately, so edges and half "
          "transparent parts differ slightly; materials; importers that require exactly 248 bytes refuse the file of a scene "
          "with objects: use preview-3dgs",
      .write = write_ply_3dgs};
}

ExportFormat ply_albedo_format() {
  return {.name = "ply-albedo",
          .summary = "flat ellipsoids with albedo and materials, for programs that light splats themselves",
          .holds =
              "position, rotation, scales (the third is 1e-6 scene units), opacity, albedo as sRGB colour and normals that face "
              "out, of every diffuse surfel; roughness, f0, specular weight, transmission and confidence as further properties",
          .loses =
              "the light of the photos, and surfels that show it; view dependence; reflections, and what is seen through glass "
              "alone; programs that do not know the property transmission show glass opaque",
          .of_albedo = true,
          .write = write_ply_albedo};
}

ExportFormat preview_3dgs_format() {
  return {
      .name = "preview-3dgs",
      .summary = "what all layers show together, as one 3D Gaussian scene, sRGB colour",
      .holds =
          "the opaque twin of the scene, or its diffuse layer, as flat ellipsoids with spherical harmonics fitted to the "
          "composed pictures: reflections and what glass shows are surfels like all others; padded with zeros to degree 3: "
          "45 f_rest, always 248 bytes a surfel",
      .loses =
          "the layers; what glass and mirrors show follows the eye only as far as surfels behind their surfaces and spherical "
          "harmonics can; linear radiance; materials",
      .write = write_preview_3dgs};
}

}  // namespace vitrine
