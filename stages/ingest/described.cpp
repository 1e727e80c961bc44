// Cost estimate of the ingest stage.
#include <algorithm>
#include <cmath>

#include "stages/ingest/ingest.h"
#include "stages/training_cost.h"

namespace vitrine {

StageCost ingest_cost(const CostTerms& t) {
  const double in = t.capture.photographed_mpx, out = ingested_mpx(t);
  constexpr double kMiB = 1024.0 * 1024.0, kBytesPerPixel = 52;  // main part of a decoder's working set (README.md)
  const double budget_mib = 3072, each = in / t.photos() * 1e6 * kBytesPerPixel / kMiB;
  const double at_once = std::clamp(std::floor(budget_mib / std::max(each, 1.0)), 1.0, double(t.threads));
  return stage_cost(0.02 * in + 0.255 * out, 0.86, 40 + at_once * each, 4.8 * out);
}

}  // namespace vitrine
