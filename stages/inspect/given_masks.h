// Would these masks be taken? The same files are read and refused for the same reasons as by the stages that use masks
// (core/camera/photo_masks.h), before anything is computed.
#pragma once

#include <filesystem>

#include "stages/inspect/findings.h"

namespace vitrine {

// `masks`: a folder, or a transforms.json with mask_path.
std::vector<Finding> mask_findings(const std::filesystem::path& masks, const std::vector<PhotoFacts>& photos);

}  // namespace vitrine
