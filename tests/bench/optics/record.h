// A comparison as a file of tests/results ("vitrine-optics 1"), from which the table of README.md is made.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/optics/arms.h"
#include "tests/bench/optics/summary.h"

namespace vitrine {

struct OpticsLabel {
  std::string commit, cpu, date;
  int cores = 0;
  std::vector<int> seeds, training_seeds;
  std::vector<Arm> arms;
  int steps = 0, surfels = 0, max_side = 0;
};

std::string optics_record(const OpticsLabel& label, const OpticsSummary& summary);

}  // namespace vitrine
