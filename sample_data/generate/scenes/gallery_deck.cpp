#include "sample_data/generate/scenes/gallery_deck.h"

#include <algorithm>

namespace vitrine::generate {
namespace {

constexpr uint64_t kHundred = 100, kDozen = 12, kDeckPurpose = 1;

uint64_t first_of_dozen(uint64_t seed) {
  const uint64_t within = (seed - 1) % kHundred;
  return seed - within % kDozen;
}

bool goes_with(const PieceKind& kind, const std::vector<const PieceKind*>& held) {
  return std::none_of(held.begin(), held.end(),
                      [&](const PieceKind* other) { return other == &kind || (kind.hangs && other->hangs); });
}

template <class T>
void refill(std::vector<T>& deck, std::vector<T> cards, Draw& draw) {
  draw.shuffle(std::span<T>(cards));
  deck.insert(deck.end(), cards.begin(), cards.end());
}

}  // namespace

bool seed_has_gloss(uint64_t seed) { return seed % 5 != 0; }

std::vector<const PieceKind*> dealt_kinds(uint64_t seed) {
  std::vector<const PieceKind*> every;
  for (const PieceKind& kind : glossy_kinds()) every.push_back(&kind);
  Draw draw(first_of_dozen(seed), kDeckPurpose);
  std::vector<const PieceKind*> kinds, held;
  std::vector<size_t> counts;
  for (uint64_t s = first_of_dozen(seed); s <= seed; ++s) {
    held.clear();
    if (!seed_has_gloss(s)) continue;
    if (counts.empty()) refill(counts, {2, 3, 4}, draw);
    for (; held.size() < counts.front();) {
      auto next = std::find_if(kinds.begin(), kinds.end(), [&](const PieceKind* kind) { return goes_with(*kind, held); });
      if (next == kinds.end()) {
        refill(kinds, every, draw);
        continue;
      }
      held.push_back(*next);
      kinds.erase(next);
    }
    counts.erase(counts.begin());
  }
  return held;
}

}  // namespace vitrine::generate
