// Three small real stages for tests of stage_main and of the pipeline. They compute something that can be checked by hand, take
// as long as they are told to, keep checkpoints, and fail in every way a stage can fail.
//
//   collect{photos, notes?} -> collect/list.txt  (name, size per file)   upper{collect} -> upper/list.txt (in capitals)
//   join{collect, upper}    -> join/joined.txt   (both, one behind the other)
#pragma once

#include "stages/stage.h"

namespace vitrine::test_stages {

struct CollectConfig {
  int repeat = 1;     // steps; each appends the whole list once
  int step_ms = 0;    // pause per step
  int memory_mb = 0;  // held from the middle on
  bool warn = false;
  std::string fail = "no";  // how to fail after half of the steps
  std::string label;
  std::string foot;  // file with the last lines
};
struct UpperConfig {
  bool reverse = false;
  std::string word = "none";
};
struct JoinConfig {
  std::string separator = "--";
  std::vector<double> weights = {1, 2};
};
void describe(Describer& d, CollectConfig& c);
void describe(Describer& d, UpperConfig& c);
void describe(Describer& d, JoinConfig& c);

Stage collect_stage();
Stage upper_stage();
Stage join_stage();

}  // namespace vitrine::test_stages
