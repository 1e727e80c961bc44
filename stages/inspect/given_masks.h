// Checks the user's masks before a run. Reads and rejects files like the stages that use masks (core/intake/masks/photo_masks.h).
#pragma once

#include <filesystem>

#include "stages/inspect/findings.h"

namespace vitrine {

// `masks`: a folder, or a transforms.json with mask_path.
std::vector<Finding> mask_findings(const std::filesystem::path& masks, const std::vector<PhotoFacts>& photos);

}  // namespace vitrine
