// How sure the masks of a class are, as the masks stage says in its report (masks/report.json).
#pragma once

#include <filesystem>

#include "core/camera/mask_files.h"

namespace vitrine {

struct MaskOrigin {
  bool guessed = false;     // proposed by the stage itself, which is not sure
  bool propagated = false;  // from few marks or none: edges may be off by pixels
};

// `artifact`: the folder that holds masks/. Masks without a report are the user's own. Throws Error{Input}.
MaskOrigin mask_origin(const std::filesystem::path& artifact, MaskClass kind);

}  // namespace vitrine
