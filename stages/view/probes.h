// What polished surfaces mirror under another light, seen from the middle of each: how the mesh sends light on in all directions
// (core/relight/light_transfer.h), and how far it is. The page looks a reflected ray up by walking along it until its distance
// from the middle is that of the picture. (Under the light of the photos it sends rays through the reflection layer.)
//
// Directions by the octahedral map (core/light/octahedral.h).
#pragma once

#include <vector>

#include "stages/view/page_surfels.h"

namespace vitrine {

inline constexpr int kProbeSide = 128;
inline constexpr size_t kMostProbes = 4;

struct Probe {
  Vec3d centre{};
  // [side, side] rows first
  std::vector<Transfer> sent;  // radiance for light whose coefficients are 1
  std::vector<float> open;     // share of light from outside
  std::vector<float> depth;    // distance of what sends it; 0: the sky
};

// From so far on a ray that leaves a surface is free of the mesh and the surfels of that surface.
float clear_of_surface(const RelitScene& scene, const LightTransfer& transfer);

// In the middle of each known opaque shape; without any, of the polished surfels; without those, in `middle`. Never empty.
std::vector<Probe> probes(const RelitScene& scene, const LightTransfer& transfer, const Vec3d& middle);

// Blocks probe, probe_constant (add_transfers) and probe_way (open, depth): one probe behind the other.
void add_probes(std::span<const Probe> probes, PageBlocks& blocks);

}  // namespace vitrine
