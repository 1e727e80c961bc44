// An artifact's files in the folder where people look for them: hard links, or copies where links are not possible.
#pragma once

#include <set>
#include <string>

#include "core/artifact/manifest.h"
#include "core/base/file.h"

namespace vitrine {

// Links every output of `entry` into `folder` under its own path. Files of `before` (what stood there from an earlier artifact of
// the stage) that the new one does not have are removed, unless somebody has replaced them. Paths in `kept` are left alone.
void publish(const fs::path& entry, const Manifest& manifest, const fs::path& folder, const Manifest* before = nullptr,
             const std::set<std::string>& kept = {});

}  // namespace vitrine
