// Options that a stage lowers to stay within --max-memory. The decision precedes the cache key and uses the names and sizes of
// the inputs: the key then covers the lowered options, and a run with more memory does not reuse the reduced result.
#pragma once

#include "stages/stage.h"

namespace vitrine {

using InputPaths = std::map<std::string, std::filesystem::path>;  // given inputs by name

struct FittedOption {
  std::string path, value;  // option and its new value
  std::string code, text;   // of the warning
};
using StageFit = std::function<std::vector<FittedOption>(const Stage& stage, size_t max_memory_bytes, const InputPaths& inputs)>;

int stage_main(Stage stage, int argc, char** argv, const StageFit& fit);

}  // namespace vitrine
