// Inputs of one run of a stage: paths and content digests.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/foundation/artifact/store.h"
#include "stages/stage.h"

namespace vitrine {

struct ResolvedInput {
  fs::path path;
  std::string content_digest;
};

// `words` are NAME=PATH. The path of an artifact may be an entry of a store (a folder with manifest.json), an output folder of
// `vitrine run` (its current artifact of that stage is used), or any folder with the right files. Throws Error{Input} or
// Error{Usage} for damaged, missing or unknown inputs.
std::map<std::string, ResolvedInput> resolve_inputs(const StageInfo& info, const std::vector<std::string>& words,
                                                    DigestCache& digests);

}  // namespace vitrine
