// What the later phases start from (algorithms 5.7), out of the diffuse layer as it is when they begin.
//   Which surfels a mask means is measured by rendering: the mean of the mask over the pixels of all training photos, weighted as
//   the surfel is blended there.
//   reflection     materials of the diffuse layer; copies of it, because mirrors show what is around, and a shell of far surfels;
//                  mirrors themselves are put on the hull of their masks; the paint of a coat stays as it is
//   transmittance  what the diffuse layer has behind glass becomes the layer's; glass itself is put on the hull of the masks
#pragma once

#include "core/scene/surfels/splat_scene.h"
#include "core/scene/shape/shape_set.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// Specular weight and transmission of what is neither mirror nor glass: it sends no rays.
inline constexpr float kDull = 0.002f;

struct LayerInitDesc {
  const OptimizeConfig& config;
  const Capture& capture;
  const Targets& targets;
  const ShapeSet& shapes;  // that the image formation draws (ObjectSet::drawn_shapes)
  const ShapeSet& glass;   // of all glass, visual hulls among them
  int sh_degree = 0;       // that the diffuse layer is rendered with
};

// Of every diffuse surfel, over all training photos that have the mask.
struct MaskEvidence {
  std::vector<float> weight;  // sum of blending weights
  std::vector<float> inside;  // of it inside the mask
  float share(size_t i) const { return weight[i] > 0 ? inside[i] / weight[i] : 0; }
};

struct HullCounts {
  size_t hull = 0, moved = 0;       // surfels put on the hull; surfels that left the diffuse layer for them
  std::vector<Vec3f> known_points;  // on shapes of gloss (HullPoint)
  float known_reach = 0;            // how far from them surfels lie that show it, at most
  ShapeSet shapes;                  // of the layer's role, for training
};
// Both change the diffuse layer, which grows to `diffuse_cap` at most, and give `scene` its new layer, of at most `cap` surfels.
HullCounts begin_reflection(const LayerInitDesc& desc, size_t cap, size_t diffuse_cap, SplatScene& scene);
HullCounts begin_transmittance(const LayerInitDesc& desc, size_t cap, size_t diffuse_cap, SplatScene& scene);

// Sheets of glass that are drawn from their shapes (core/render/model/sheet_pass.h) need no surfels while the scene is trained: what is
// seen through them stays in the diffuse layer until the end, when begin_transmittance() gives other programs what they expect.
bool trains_sheets(const OptimizeConfig& config, const ShapeSet& shapes);
// The sheets, with the faces that are panes. No surfel of the diffuse layer is clear from now on.
ShapeSet known_sheets(const LayerInitDesc& desc, SplatScene& scene);

}  // namespace vitrine
