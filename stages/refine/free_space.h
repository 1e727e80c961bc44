// Votes of the photos on the position of each transmittance surfel: empty space, and the side of closed glass. Each photo that
// sees the position votes:
//   empty   the position is in front of the visible surface: opaque, or glass where the mesh agrees
//   seen    the position is possible: at the surface, or behind glass
//   inside, beyond   counts of rays through closed glass that pass the position: between front and back, or after the back
// Positions behind opaque surfaces get no votes. A surfel on a pane represents the glass itself (an unexplained reflection or
// dust), so grazing photos do not count against it.
#pragma once

#include "stages/refine/glass_views.h"

namespace vitrine {

struct SurfelVotes {
  uint32_t empty = 0, seen = 0, inside = 0, beyond = 0;
  bool on_pane = false;
};
std::vector<SurfelVotes> surfel_votes(const SplatLayer& layer, std::span<const GlassView> views, const GlassMesh& mesh);

bool stands_in_empty_space(const SurfelVotes& v);
// True if all rays that pass it have left closed glass.
bool stands_beyond(const SurfelVotes& v);

}  // namespace vitrine
