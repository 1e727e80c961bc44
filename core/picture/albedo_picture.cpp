#include "core/picture/albedo_picture.h"

#include "core/model/opened_scene.h"
#include "core/model/sheet_pass.h"

namespace vitrine {

namespace {

// Everything but the glass, with its albedo. Traced glass has no opaque surfels behind it.
SurfelColors behind_glass(const SplatScene& scene, const ImageOptions& image, const DecomposedMaterials& materials) {
  SplatScene parts{.diffuse = scene.diffuse, .transmittance = scene.transmittance};
  if (image.transmission.glass != Glass::Thin) parts.diffuse.resize(0);
  OpenedScene opened;
  without_glass(parts, {}, opened);
  std::vector<Vec3f> albedo;
  for (const uint32_t i : opened.opaque) albedo.push_back(materials.albedo[i]);
  albedo.insert(albedo.end(), materials.albedo_behind_glass.begin(), materials.albedo_behind_glass.end());
  return {opened.surfels, albedo, image.diffuse.near_z};
}

}  // namespace

AlbedoPainter::AlbedoPainter(const SplatScene& scene, const ImageOptions& image, const DecomposedMaterials& materials) {
  const float near_z = image.diffuse.near_z;
  const bool sheets = draws_sheets(image);  // whose surfels are not drawn
  if (materials.albedo_behind_glass.size() == scene.transmittance.size() && (sheets || scene.transmittance.size() > 0))
    behind_.emplace(behind_glass(scene, image, materials));
  if (behind_ && sheets) return;
  first_.emplace(scene.diffuse, materials.albedo, near_z);
  if (!behind_) return;
  std::vector<Vec3f> clear;
  for (const float t : materials.transmission) clear.push_back({t, t, t});
  clear_.emplace(scene.diffuse, clear, near_z);
}

ImageF AlbedoPainter::picture(const View& view) {
  if (!first_) return behind_->picture(view);
  ImageF out = first_->picture(view);
  if (!behind_) return out;
  const ImageF clear = clear_->picture(view), behind = behind_->picture(view);
  for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] += clear.data()[i] * (behind.data()[i] - out.data()[i]);
  return out;
}

}  // namespace vitrine
