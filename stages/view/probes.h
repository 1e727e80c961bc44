// Light probes for reflections of specular surfaces under another light: seen from their centre, the radiance of the mesh in all
// directions (core/render/relight/light_transfer.h) and its distance. The page marches along a reflected ray until its distance
// from the centre matches the probe (parallax correction). (Under the light of the photos it traces rays through the reflection
// layer.)
//
// Directions: octahedral map (core/scene/light/environment.h).
//
// Directions by the octahedral map (core/scene/light/environment.h).
#pragma once

#include <vector>

#include "stages/view/page_surfels.h"

namespace vitrine {

inline constexpr int kProbeSide = 128;
inline constexpr size_t kMostProbes = 4;

struct Probe {
  Vec3d centre{};
  // [side, side] rows first
  std::vector<Transfer> sent;  // radiance for unit coefficients
  std::vector<float> open;     // share of light from outside
  std::vector<float> depth;    // distance of the surface; 0: sky
};

// At this distance a ray is clear of the mesh and the surfels of the surface it leaves.
float clear_of_surface(const RelitScene& scene, const LightTransfer& transfer);

// One probe per known opaque shape, at its centre; otherwise one at the centre of the specular surfels; otherwise one at
// `middle`. Never empty.
std::vector<Probe> probes(const RelitScene& scene, const LightTransfer& transfer, const Vec3d& middle);

// Writes blocks probe, probe_constant (add_transfers) and probe_way (open, depth); probes are concatenated.
void add_probes(std::span<const Probe> probes, PageBlocks& blocks);

}  // namespace vitrine
