// Everything but the glass of a scene in one layer (OpenedScene): the surfels of the diffuse layer that are no glass, then the
// transmittance layer; and the way back for gradients. Spherical harmonics count up to the degrees given, beyond them they are 0.
#pragma once

#include "core/render/model/frame.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

// Surfels of a diffuse layer that are no glass, ascending.
std::vector<uint32_t> opaque_surfels(const SplatLayer& diffuse);

// Degrees of spherical harmonics that are used of the two layers.
struct OpenedDegrees {
  int diffuse = 0, transmittance = 0;
};
OpenedDegrees opened_degrees(const SplatScene& scene, const ImageOptions& options);

// Shape and colour alone. Reuses the memory of `opened`.
void without_glass(const SplatScene& scene, OpenedDegrees degrees, OpenedScene& opened);
// With materials as well: a diffuse layer. Surfels of the transmittance layer have those of an opaque surface without gloss.
void without_glass_with_materials(const SplatScene& scene, OpenedDegrees degrees, OpenedScene& opened);

// Adds gradients and statistics of the opened scene's surfels to those of the layers that they come from.
struct OpenedGradients {  // of frame.opened
  const SplatLayer& surfels;
  const SurfelStatistics& statistics;
};
void give_back(OpenedDegrees degrees, const OpenedGradients& from, Frame& frame, SplatScene& grad);

}  // namespace vitrine
