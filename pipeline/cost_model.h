// How long a stage will take, and what memory and disk, from the size of the photos and the options: sums of a few terms whose
// coefficients were measured (README.md, "What a run costs"). It knows the stages by name, unlike the rest of the pipeline; a
// stage that it does not know has no estimate.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/settings.h"

namespace vitrine {

struct CaptureSize {
  size_t photos = 0;
  double photographed_mpx = 0;  // all photos together
  double aspect = 0.75;         // short over long side
  double longest_px = 0;        // of a typical photo
  double texture = 0;           // share of 16 x 16 cells with a corner
  bool masks = false;           // given by the user: layers are trained
};

// Fills in the size of a typical photo: that of the one in the middle. `sides`: shorter and longer of each photo, not empty.
void take_typical_size(std::vector<std::pair<double, double>> sides, CaptureSize& capture);
// Whether a run with these settings is given masks.
bool gives_masks(const Settings& settings);

struct StageCost {
  std::string name;
  double cpu_s = 0;
  double parallel = 0;  // share of cpu_s that more threads shorten
  size_t memory_bytes = 0, disk_bytes = 0;
  double seconds(int threads) const { return cpu_s * (1 - parallel + parallel / threads); }
};

// In the order of the graph. nullopt for stages without an estimate.
std::optional<StageCost> stage_cost(const std::string& stage, const Settings& settings, const CaptureSize& capture, int threads);

}  // namespace vitrine
