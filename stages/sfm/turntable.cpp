#include "stages/sfm/turntable.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "stages/sfm/matcher.h"

namespace vitrine {

namespace {

constexpr size_t kEnough = 8;     // minimum matches of a pair, inside or outside, to count
constexpr double kStill = 0.003;  // of the longest side: tolerance for feature localisation and a shaken tripod
constexpr double kMoves = 2 * kStill;
constexpr double kMostMatches = 0.5, kMostTurned = 0.6;
constexpr double kPairsThatTell = 1.0 / 3;
constexpr size_t kFewestPairs = 3;

struct PairCounts {
  size_t outside = 0, still = 0, inside = 0, moved = 0;
};

PairCounts counted(const TurntableDesc& desc, size_t a, size_t b, std::span<const Match> matches) {
  PairCounts n;
  const double side = std::max(desc.sides[a], desc.sides[b]);
  for (const Match& m : matches) {
    const bool in_a = desc.inside[a][m.a] != 0, in_b = desc.inside[b][m.b] != 0;
    if (in_a != in_b) continue;
    const double moved = std::hypot(double(desc.photos[a].xy[2 * m.a]) - desc.photos[b].xy[2 * m.b],
                                    double(desc.photos[a].xy[2 * m.a + 1]) - desc.photos[b].xy[2 * m.b + 1]);
    if (in_a)
      ++n.inside, n.moved += moved > kMoves * side;
    else
      ++n.outside, n.still += moved <= kStill * side;
  }
  return n;
}

}  // namespace

TurntableEvidence turntable_evidence(const TurntableDesc& desc) {
  const size_t n = desc.photos.size();
  std::vector<PackedDescriptors> packed(n);
  parallel_for(n, 1, [&](size_t i) {
    if (!desc.inside[i].empty()) packed[i] = PackedDescriptors(desc.photos[i].descriptors);
  });
  // Neighbours, and photos a twelfth of the capture apart, between which a camera on a slow orbit has moved as well.
  std::vector<std::pair<size_t, size_t>> pairs;
  for (size_t gap : {size_t{1}, std::max<size_t>(3, n / 12)})
    for (size_t i = 0; i + gap < n; ++i)
      if (!desc.inside[i].empty() && !desc.inside[i + gap].empty()) pairs.push_back({i, i + gap});
  std::vector<PairCounts> counts(pairs.size());
  parallel_for(pairs.size(), 1, [&](size_t p) {
    throw_if_interrupted();
    const auto [a, b] = pairs[p];
    counts[p] = counted(desc, a, b, match(packed[a], packed[b]));
  });
  TurntableEvidence e{.pairs = pairs.size(), .why = {}};
  for (const PairCounts& c : counts) {
    if (c.outside >= kEnough) {
      ++e.outside_told;
      e.outside_still += double(c.still) >= kMostMatches * double(c.outside);
    }
    if (c.inside >= kEnough) {
      ++e.inside_told;
      e.inside_moves += double(c.moved) >= kMostMatches * double(c.inside);
    }
  }
  const auto most = [](size_t part, size_t of) { return of > 0 && double(part) >= kMostTurned * double(of); };
  const auto tell = [&](size_t pairs_told) {
    return pairs_told >= kFewestPairs && double(pairs_told) >= kPairsThatTell * double(e.pairs);
  };
  const std::string figures =
      fmt::format("outside the object most matches stand still in {} of {} pairs of photos, on it most move in {} of {}",
                  e.outside_still, e.outside_told, e.inside_moves, e.inside_told);
  e.turntable =
      tell(e.outside_told) && tell(e.inside_told) && most(e.outside_still, e.outside_told) && most(e.inside_moves, e.inside_told);
  if (!tell(e.outside_told))
    e.why = fmt::format("only {} of {} pairs of photos have matches outside the object", e.outside_told, e.pairs);
  else if (!tell(e.inside_told))
    e.why = fmt::format("only {} of {} pairs of photos have matches on the object", e.inside_told, e.pairs);
  else
    e.why = figures;
  return e;
}

}  // namespace vitrine
