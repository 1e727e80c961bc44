// Inpainting of regions that no photo sees, outside all images or occluded: novel views would see holes there. The large planes
// of the scene (walls, floor, table) are extended: cells that no photo sees, or sees through, get colours from Laplace's
// equation, up to a limited distance from the last seen cell. The sky is extended in the same way. Surfels that would be visible
// in a training photo are removed. This is a guess of colours only; no geometry is added. Also moves surfels that photos see only
// through glass from the transmittance to the diffuse layer.
#pragma once

#include <span>

#include "core/scene/surfels/splat_scene.h"
#include "core/observe/stereo/scene_planes.h"
#include "core/learn/trainer/capture.h"

namespace vitrine {

// Largest number of added surfels as a fraction of max_gaussians.
inline constexpr double kMostUnseen = 0.2;

// Concatenates `first` and `second`, with the spherical harmonics degree of `first`.
SplatLayer joined(const SplatLayer& first, const SplatLayer& second);

// Opaque surfels of a scene with thin glass, including those of the transmittance layer.
SplatLayer seen_through_glass(const SplatScene& scene);

// Moves surfels from the transmittance to the end of the diffuse layer: those on the large planes or their extension that the
// diffuse layer with its glass occludes in all training photos. Without them, a wall seen only through thin glass is a hole for a
// new camera that looks past the glass. Through the glass they look the same, up to the spherical harmonics degree of the diffuse
// layer. Returns the ascending indices of the surfels that stay; at least one, so that the layer exists.
std::vector<uint32_t> bring_out_from_behind_glass(const Capture& capture, std::span<const ScenePlane> planes, SplatScene& scene);

// Returns at most `most` surfels for the diffuse layer, with one colour for all directions and initial materials; the cells grow
// until they fit. `shown`: the trained surfels without glass; glass would hide the content behind it, and the region would be
// inpainted. `background`: distance of the sky; 0 = no sky.
SplatLayer inpainted_planes(const SplatLayer& shown, const Capture& capture, std::span<const ScenePlane> planes,
                            double background, size_t most);

}  // namespace vitrine
