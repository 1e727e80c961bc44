// The shapes for a person to judge: some photos with the silhouettes of the shapes drawn into them.
#pragma once

#include <filesystem>

#include "core/camera/view_set.h"
#include "core/shape/shape_set.h"

namespace vitrine {

// Sheets blue, mirrors orange, coats green.
void write_contact_sheet(const std::filesystem::path& file, const std::filesystem::path& sfm, const ViewSet& views,
                         const ShapeSet& shapes);

}  // namespace vitrine
