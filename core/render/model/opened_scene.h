// Scene without glass as one layer (OpenedScene): the opaque surfels of the diffuse layer, then the transmittance layer; and
// the transfer of its gradients back to the layers. Spherical harmonics above the given degrees are 0.
#pragma once

#include "core/render/model/frame.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

// Indices of the opaque surfels of a diffuse layer, ascending.
std::vector<uint32_t> opaque_surfels(const SplatLayer& diffuse);

// Degrees of spherical harmonics used of the two layers.
struct OpenedDegrees {
  int diffuse = 0, transmittance = 0;
};
OpenedDegrees opened_degrees(const SplatScene& scene, const ImageOptions& options);

// Copies shape and colour only. Reuses the memory of `opened`.
void without_glass(const SplatScene& scene, OpenedDegrees degrees, OpenedScene& opened);
// Copies materials too: a diffuse layer. Surfels of the transmittance layer get the materials of an opaque, non-specular surface.
void without_glass_with_materials(const SplatScene& scene, OpenedDegrees degrees, OpenedScene& opened);

// Adds gradients and statistics of the scene without glass to the layers that its surfels were copied from.
struct OpenedGradients {  // of frame.opened
  const SplatLayer& surfels;
  const SurfelStatistics& statistics;
};
void give_back(OpenedDegrees degrees, const OpenedGradients& from, Frame& frame, SplatScene& grad);

}  // namespace vitrine
