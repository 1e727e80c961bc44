// Thin shell or solid glass? A closed shell in the mesh may be either: a bottle and a paperweight look alike from outside. What
// tells them apart is where the photos show the room behind it. Per region (connected piece of glass) the photos are compared
// with four pictures: rays straight on or bent by Snell's law, each with what training put behind the glass and without it. The
// latter counts since a training on straight rays paints a picture of the bent room behind solid glass.
#pragma once

#include "core/foundation/base/json.h"
#include "core/render/model/thick_glass.h"
#include "core/scene/objects/object_labels.h"
#include "stages/refine/glass_views.h"

namespace vitrine {

struct RegionThickness {
  uint32_t region = 0;
  size_t faces = 0, photos = 0;
  size_t pixels = 0;                         // of those photos whose rays go in and out again
  size_t total_reflection = 0, no_exit = 0;  // whose do not: they keep the straight ray
  // Residuals: mean squared differences to the photos, sRGB.
  double straight = 0, straight_without = 0, bent = 0, bent_without = 0;

  bool tested() const;  // pixels enough
  bool thick() const;   // tested, and bent rays are clearly nearer to the photos
};

struct ThicknessDesc {
  const Capture& capture;
  const TrainedScene& scene;
  std::span<const GlassView> seen;    // training photos: what stands behind which glass
  std::span<const GlassView> judges;  // photos to compare with
  const GlassMesh& mesh;
  float ior;
  size_t level;  // of the pyramid, as the views have it
};
// Of the regions that are closed somewhere, largest first.
std::vector<RegionThickness> region_thickness(const ThicknessDesc& desc);

// [mesh.regions] 1 where photos see closed glass in enough pixels.
std::vector<uint8_t> closed_regions(std::span<const GlassView> views, const GlassMesh& mesh);
// [layer.size()] 1 = most photos that see the surfel's place see it through the closed glass of the chosen regions.
std::vector<uint8_t> seen_through(const SplatLayer& layer, std::span<const GlassView> views, std::span<const uint8_t> chosen);
// The surfels with keep[i] != 0. Glass shows nothing without a layer, so that of a layer that would be empty one invisible surfel
// stays.
SplatLayer kept_or_blank(const SplatLayer& layer, std::span<const uint8_t> keep);
// [mesh.regions] 1 where most pixels that see the region's closed glass show an object of role solid_glass.
std::vector<uint8_t> regions_of_solid_glass(const LabelledObjects& objects, std::span<const GlassView> views,
                                            const GlassMesh& mesh);
// The scene with bent rays in the chosen regions; as it is, when there are none.
TrainedScene with_thick_glass(TrainedScene scene, const GlassMesh& mesh, std::span<const uint8_t> chosen, float ior);

nlohmann::ordered_json thickness_json(std::span<const RegionThickness> regions);
void log_thickness(std::span<const RegionThickness> regions);

}  // namespace vitrine
