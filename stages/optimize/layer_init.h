// Initial surfels of the reflection and the transmittance layer (algorithms 5.7), made from the diffuse layer.
//   Mask membership of a surfel is the mean mask value over the pixels of all training photos, weighted by its blending weight.
//   reflection     materials of the diffuse layer; copies of its surfels, because mirrors show the surroundings, and a sphere of
//                  far surfels; diffuse surfels on the visual hull of the mirror masks; the diffuse colour under a coat is kept
//   transmittance  the diffuse surfels behind glass move to the layer; diffuse surfels on the visual hull of the glass masks
#pragma once

#include <span>
#include <vector>

#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"
#include "core/scene/shape/shape_set.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// Initial specular weight and transmission outside mirrors and glass: such surfels send no rays.
inline constexpr float kDull = 0.002f;

struct LayerInitDesc {
  const OptimizeConfig& config;
  const Capture& capture;
  const Targets& targets;
  const ShapeSet& shapes;  // rendered by the image formation (ObjectSet::drawn_shapes)
  const ShapeSet& glass;   // shapes of all glass, including visual hulls
  int sh_degree = 0;       // the diffuse layer's rendered degree
};

// Mask membership of each diffuse surfel, over all training photos that have the mask.
struct MaskEvidence {
  std::vector<float> weight;  // sum of blending weights
  std::vector<float> inside;  // the part inside the mask
  float share(size_t i) const { return weight[i] > 0 ? inside[i] / weight[i] : 0; }
};

struct HullCounts {
  size_t hull = 0, moved = 0;       // surfels placed on the shapes; diffuse surfels removed for them
  std::vector<Vec3f> known_points;  // surfels placed on the visual hull or shape; diffuse surfels removed for them
  float known_reach = 0;            // largest distance from known_points at which a surfel shows a known shape
  ShapeSet shapes;                  // shapes of this role, for training
};
// Both change the diffuse layer, up to `diffuse_cap` surfels, and create the new layer of `scene` with at most `cap` surfels.
HullCounts begin_reflection(const LayerInitDesc& desc, size_t cap, size_t diffuse_cap, SplatScene& scene);
HullCounts begin_transmittance(const LayerInitDesc& desc, size_t cap, size_t diffuse_cap, SplatScene& scene);

// True for thin glass that is rendered from its shapes (core/render/model/sheet_pass.h). It needs no surfels during training:
// what is seen through it stays in the diffuse layer until begin_transmittance() creates the layer for other stages at the end.
bool trains_sheets(const OptimizeConfig& config, const ShapeSet& shapes);
// The shapes of thin glass, with the faces that are panes. Sets the transmission of all diffuse surfels to opaque.
ShapeSet known_sheets(const LayerInitDesc& desc, SplatScene& scene);

// Classification of the faces of a glass box as panes or opaque faces.

// Marks faces as opaque if training photos show a surface right at the face for most pixels of the transparent masks whose rays
// leave through it: the floor of a display case is no pane, though the masks end there. Other faces are clear. Entries that are
// not boxes, or whose clear faces are given, are returned unchanged. `depths`: [photo] z-depth of the diffuse layer at `level`, 0
// = none; empty for held-out photos.
ShapeSet::Entry with_clear_panes(ShapeSet::Entry sheet, const Capture& capture, const Targets& targets,
                                 std::span<const std::vector<float>> depths, size_t level);

}  // namespace vitrine
