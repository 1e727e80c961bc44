// What polished surfaces mirror under another light, seen from the middle of each: which surfel stands in which direction, and
// how far. The page looks a reflected ray up by walking along it until its distance from the middle is that of the picture, so
// that no ray is sent through the scene. (Under the light of the photos it sends rays through the reflection layer.)
//
// Directions by the octahedral map (Engelhardt and Dachsbacher 2008), +z in the middle: texel (x, y) of side s shows the
// direction of p = 2 (x + 1/2, y + 1/2)/s - 1: (p, 1 - |p.x| - |p.y|), folded outwards where that is below 0, normalised.
#pragma once

#include <vector>

#include "core/picture/trained_scene.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

inline constexpr int kProbeSide = 192;
inline constexpr size_t kMostProbes = 4;

Vec3f octahedral_direction(int x, int y, int side);

struct Probe {
  Vec3d centre{};
  // [side, side] rows first
  std::vector<uint32_t> surfel;  // which surfel of the page stands there, what polished things lie around the middle left out
  std::vector<float> depth;      // its distance
};
inline constexpr uint32_t kNoSurfel = UINT32_MAX;

// In the middle of each known opaque shape; without any, of the polished surfels; without those, in `middle`. Never empty.
std::vector<Probe> probes(const TrainedScene& scene, const PageSurfels& surfels, const Vec3d& middle);

// Blocks probe_surfel, probe_depth: one probe behind the other.
void add_probes(std::span<const Probe> probes, PageBlocks& blocks);

}  // namespace vitrine
