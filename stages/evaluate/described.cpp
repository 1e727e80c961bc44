// Cost estimate of the evaluate stage.
#include <cmath>
#include <filesystem>

#include "stages/evaluate/evaluate.h"
#include "stages/training_cost.h"

namespace vitrine {

StageCost evaluate_cost(const CostTerms& t) {
  const double every = t.number("optimize.holdout_every");
  const double held = every > 0 ? std::ceil(t.photos() / every) : 0, mpx = t.mpx(trained_side(t));
  double cpu_s = 2 + 5 * held * mpx + 0.2 * t.photos() * mpx, memory = 150 + 12 * t.photos() * mpx;
  if (t.is_given("input.truth")) {
    // A true mesh is sampled and searched; so are depths and normals of all views. True pictures under other lights ask for ours.
    cpu_s += 14;
    memory += 610;
    std::error_code ec;
    if (std::filesystem::is_directory(std::filesystem::path(t.text("input.truth")) / "relit", ec)) cpu_s += 12;
  }
  return stage_cost(cpu_s, 0.65, memory, 5 * held * mpx);
}

}  // namespace vitrine
