// The objects for a person to judge: some photos with their labels, names, and the silhouettes of their shapes.
#pragma once

#include <filesystem>

#include "core/scene/camera/view_set.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine {

// Glass blue, mirrors orange, coats green; guessed objects are drawn paler.
void write_contact_sheet(const std::filesystem::path& file, const std::filesystem::path& sfm, const ViewSet& views,
                         const LabelledObjects& objects);

}  // namespace vitrine
