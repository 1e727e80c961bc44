// Space that the photos show to be empty, and on which side of closed glass the surfels of the transmittance layer stand. Every
// photo that sees a surfel's place votes:
//   empty   the place lies in front of what the photo shows: of an opaque surface, or of the glass where the mesh agrees on it
//   seen    it may be there: at the surface, or behind glass
//   inside, beyond   of the rays through closed glass that pass the place: between front and back, or past the back
// Nothing is said about places behind opaque surfaces. What a surfel on a pane shows is on the glass itself, a reflection that no
// layer explains or dust: photos that see it edge on do not contradict it.
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
