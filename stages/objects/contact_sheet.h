// Contact sheet of the objects for visual inspection: some photos with labels, names, and silhouettes of the shapes.
#pragma once

#include <filesystem>

#include "core/scene/camera/view_set.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine {

// Glass is blue, mirrors orange, coats green; guessed objects are paler.
void write_contact_sheet(const std::filesystem::path& file, const std::filesystem::path& sfm, const ViewSet& views,
                         const LabelledObjects& objects);

}  // namespace vitrine
