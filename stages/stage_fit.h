// What a stage may give up to keep within --max-memory. It is decided before the key is made, from what its inputs are called and
// say of their sizes: the key tells what is computed, and a run with more memory is not served what was made with less.
#pragma once

#include "stages/stage.h"

namespace vitrine {

using InputPaths = std::map<std::string, std::filesystem::path>;  // of the inputs that are given, by name

struct FittedOption {
  std::string path, value;  // the option, and what it is set to
  std::string code, text;   // of the warning that says so
};
using StageFit = std::function<std::vector<FittedOption>(const Stage& stage, size_t max_memory_bytes, const InputPaths& inputs)>;

int stage_main(Stage stage, int argc, char** argv, const StageFit& fit);

}  // namespace vitrine
