// The output folder of a run (project), where people look for the files of artifacts: hard links, or copies where links are not
// possible. <project>/.cache is its store, .cache/current.json says which artifact of each stage is the one whose files are
// there.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/foundation/artifact/manifest.h"
#include "core/foundation/base/file.h"

namespace vitrine {

// Links every output of `entry` into `folder` under its own path. Files of `before` (the previous artifact of the stage) that the
// new one lacks are removed, unless the user has replaced them. Paths in `kept` are not touched.
void publish(const fs::path& entry, const Manifest& manifest, const fs::path& folder, const Manifest* before = nullptr,
             const std::set<std::string>& kept = {});

fs::path store_of(const fs::path& project);
// stage -> key; empty when the folder is no project. A file that cannot be read counts as empty: it is rebuilt by the next run.
std::map<std::string, std::string> current_keys(const fs::path& project);
std::optional<std::string> current_key(const fs::path& project, std::string_view stage);
void set_current_key(const fs::path& project, const std::string& stage, const std::string& key);
void remove_current_key(const fs::path& project, const std::string& stage);

}  // namespace vitrine
