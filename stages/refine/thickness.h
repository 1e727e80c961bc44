// Classification of closed glass as thin glass or solid glass. A bottle and a paperweight have the same outer surface; the
// position of the refracted background in the photos distinguishes them. Per region (connected component of glass) the photos are
// compared with four pictures: straight rays or rays refracted by Snell's law, each with and without the trained content behind
// the glass. The variant without it is needed because training with straight rays paints the refracted room behind solid glass.
#pragma once

#include "core/foundation/base/json.h"
#include "core/render/model/thick_glass.h"
#include "core/scene/objects/object_labels.h"
#include "stages/refine/glass_views.h"

namespace vitrine {

struct RegionThickness {
  uint32_t region = 0;
  size_t faces = 0, photos = 0;
  size_t pixels = 0;                         // of those photos, with rays that enter and leave
  size_t total_reflection = 0, no_exit = 0;  // with other rays: they stay straight
  // Residuals: mean squared sRGB differences to the photos.
  double straight = 0, straight_without = 0, bent = 0, bent_without = 0;

  bool tested() const;  // enough pixels
  bool thick() const;   // tested, and refracted rays are clearly closer to the photos
};

struct ThicknessDesc {
  const Capture& capture;
  const TrainedScene& scene;
  std::span<const GlassView> seen;    // training photos, for the content behind each glass
  std::span<const GlassView> judges;  // photos to compare with
  const GlassMesh& mesh;
  float ior;
  size_t level;  // pyramid level of the views
};
// Regions with closed glass, largest first.
std::vector<RegionThickness> region_thickness(const ThicknessDesc& desc);

// [mesh.regions] 1 if photos see closed glass in enough pixels.
std::vector<uint8_t> closed_regions(std::span<const GlassView> views, const GlassMesh& mesh);
// [layer.size()] 1 = most photos that see the surfel's position see it through closed glass of the chosen regions.
std::vector<uint8_t> seen_through(const SplatLayer& layer, std::span<const GlassView> views, std::span<const uint8_t> chosen);
// The surfels with keep[i] != 0. If none remains, one invisible surfel is kept, because glass needs a transmittance layer.
SplatLayer kept_or_blank(const SplatLayer& layer, std::span<const uint8_t> keep);
// [mesh.regions] 1 if most pixels of the region's closed glass show an object of role solid_glass.
std::vector<uint8_t> regions_of_solid_glass(const LabelledObjects& objects, std::span<const GlassView> views,
                                            const GlassMesh& mesh);
// The scene with refracted rays in the chosen regions; unchanged if there are none.
TrainedScene with_thick_glass(TrainedScene scene, const GlassMesh& mesh, std::span<const uint8_t> chosen, float ior);

nlohmann::ordered_json thickness_json(std::span<const RegionThickness> regions);
void log_thickness(std::span<const RegionThickness> regions);

}  // namespace vitrine
