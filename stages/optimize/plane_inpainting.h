// What no photo shows, because it lies beyond the edges of all of them or something hides it: a view from a new place would
// look there into nothing. The large planes of the scene (walls, floor, table) go on there: their cells that no photo sees, and
// through which no photo looks, take the smoothest continuation of the colours around (Laplace's equation), up to a short way
// from the last cell that is seen; and so does the sky. What a photo would see of it through what was trained is left out. A
// guess, and of colours alone: what stands there nobody knows.
// And what photos show through glass alone, because the glass hides it.
#pragma once

#include <span>

#include "core/scene/surfels/splat_scene.h"
#include "core/observe/stereo/scene_planes.h"
#include "core/learn/trainer/capture.h"

namespace vitrine {

// Of the surfels that training may have: most that what no photo shows takes beyond them.
inline constexpr double kMostUnseen = 0.2;

// `second` behind `first`, with the spherical harmonics of `first` as far as both go.
SplatLayer joined(const SplatLayer& first, const SplatLayer& second);

// What photos see of a scene whose glass is thin: all that is opaque, of the transmittance layer as well.
SplatLayer seen_through_glass(const SplatScene& scene);

// A wall that photos know through thin glass alone is a hole to a new camera that looks past the glass. Surfels of the
// transmittance layer that stand on the large planes or their continuation, and that the diffuse layer with its glass hides from
// all training photos, go to the end of the diffuse layer, where they show the same through the glass as far as the spherical
// harmonics of that layer go. Returns which stay behind, ascending: at least one, so that there is a layer.
std::vector<uint32_t> bring_out_from_behind_glass(const Capture& capture, std::span<const ScenePlane> planes, SplatScene& scene);

// Surfels for the diffuse layer, of one colour from all sides, materials as at the start of training; at most `most`, coarser
// where that is needed. `shown`: the surfels as they have been trained. Glass among them would hide what stands behind it, and
// guesses would be put there.
// `background`: distance of the sky; 0 = there is none.
SplatLayer inpainted_planes(const SplatLayer& shown, const Capture& capture, std::span<const ScenePlane> planes,
                            double background, size_t most);

}  // namespace vitrine
