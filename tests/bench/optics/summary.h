// What a comparison says: the figures of every scene and arm, and by how much each arm differs from the first.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/optics/protocol.h"

namespace vitrine {

// A figure of an arm minus that of the first arm: of each pair with the same scene and training seed where both were measured,
// the mean over the seeds of a scene, then over the scenes.
struct Gain {
  double mean = 0, deviation = 0;  // of the scenes around their mean (n - 1); 0 for one scene
  double worst = 0;                // of the scenes
  int scenes = 0;
  bool counts = false;  // at least two scenes, and the mean is an improvement larger than the deviation
};

struct ArmFigures {
  std::string arm;
  Figures figures;  // mean over the training seeds
};
struct SceneSummary {
  std::string scene, kinds;  // "glass mirror coated", "none"
  std::vector<ArmFigures> arms;
};
struct ArmGains {
  std::string arm;
  std::map<std::string, Gain> gains;  // by figure
};
struct OpticsSummary {
  std::string first_arm;
  std::vector<SceneSummary> scenes;
  std::vector<ArmGains> gains;  // of the other arms
};

// Scenes and arms in the order of the results; `first_arm` is that of the command line, whether it has results or not.
OpticsSummary summary_of(const std::vector<OpticsResult>& results, const std::string& first_arm);
std::string summary_text(const OpticsSummary& summary);

}  // namespace vitrine
