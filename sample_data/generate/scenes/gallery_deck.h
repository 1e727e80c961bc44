// Which glossy kinds a seed holds. Seeds come in dozens (1 to 12, 13 to 24, ..., counted anew in every hundred); a dozen deals
// shuffled decks of all kinds, two to four cards a seed, so that every full dozen holds every kind. Every fifth seed gets none.
#pragma once

#include <cstdint>
#include <vector>

#include "sample_data/generate/scenes/gallery_pieces.h"

namespace vitrine::generate {

bool seed_has_gloss(uint64_t seed);
std::vector<const PieceKind*> dealt_kinds(uint64_t seed);  // seed >= 1; at most one of them hangs on the wall

}  // namespace vitrine::generate
