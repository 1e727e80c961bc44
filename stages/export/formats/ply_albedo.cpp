// ply-albedo: the surfels as in ply-3dgs, for programs that light splats themselves. Their colour is the albedo of the decompose
// stage, the same from all sides; their normals face out; and the materials stand behind the properties of the dialect:
//   roughness  f0_r f0_g f0_b  specular_weight  transmission      linear, 0 to 1 (core/picture/decomposed_materials.h)
// Colours are sRGB as in all files of the dialect. Surfels that show the light of the photos are no surface and left out.
#include "core/math/color.h"
#include "core/scene/activation.h"
#include "stages/export/bake/outward_normals.h"
#include "stages/export/formats/format.h"
#include "stages/export/formats/gaussian_ply.h"

namespace vitrine {
namespace {

constexpr float kNormalReach = 3;  // mean edges of the mesh: so far from it surfels still lie on it

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
  for (size_t to = 0; to < kept.size(); ++to) {
    const uint32_t i = kept[to];
    for (const Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity})
      std::copy_n(diffuse.at(a, i), diffuse.width(a), layer.at(a, to));
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::ShDc, to)[c] = (srgb_from_linear(found.albedo[i][c]) - 0.5f) / kShDc;
    const float values[] = {found.roughness[i],       found.f0[i].x,        found.f0[i].y, found.f0[i].z,
                            found.specular_weight[i], found.transmission[i]};
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

}  // namespace

ExportFormat ply_albedo_format() {
  return {.name = "ply-albedo",
          .summary = "flat ellipsoids with albedo and materials, for programs that light splats themselves",
          .holds =
              "position, rotation, scales (the third is 1e-6 scene units), opacity, albedo as sRGB colour and normals that face "
              "out, of every diffuse surfel; roughness, f0, specular weight and transmission as further properties",
          .loses =
              "the light of the photos, and surfels that show it; view dependence; reflections, and what is seen through glass "
              "alone; programs that do not know the property transmission show glass opaque",
          .of_albedo = true,
          .write = write_ply_albedo};
}

}  // namespace vitrine
