// Checks the user's masks and depth maps before a run. Reads and rejects files like the stages that use them
// (core/intake/masks/photo_masks.h, core/intake/depth/depth_files.h).
#pragma once

#include <filesystem>

#include "core/foundation/base/error.h"
#include "stages/inspect/findings.h"

namespace vitrine {

// The finding of files that a run would refuse.
Finding refused_input(const Error& e);

// `masks`: a folder, or a transforms.json with mask_path.
std::vector<Finding> mask_findings(const std::filesystem::path& masks, const std::vector<PhotoFacts>& photos);
// `depth`: a folder, or a transforms.json with depth_file_path.
std::vector<Finding> depth_findings(const std::filesystem::path& depth, const std::vector<PhotoFacts>& photos);

}  // namespace vitrine
