// Output folder of a run (the project): the user-visible files of artifacts, as hard links, or copies if links are not
// possible. <project>/.cache is the store; .cache/current.json lists the published artifact of each stage.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/foundation/artifact/manifest.h"
#include "core/foundation/base/file.h"

namespace vitrine {

// Links every output of `entry` into `folder` under its own path. Removes files of `before` (the previous artifact of the
// stage) that the new one lacks, unless the user has replaced them. Paths in `kept` are not touched.
void publish(const fs::path& entry, const Manifest& manifest, const fs::path& folder, const Manifest* before = nullptr,
             const std::set<std::string>& kept = {});

fs::path store_of(const fs::path& project);
// stage -> key; empty if the folder is not a project. An unreadable file counts as empty: the next run rebuilds it.
std::map<std::string, std::string> current_keys(const fs::path& project);
std::optional<std::string> current_key(const fs::path& project, std::string_view stage);
void set_current_key(const fs::path& project, const std::string& stage, const std::string& key);
void remove_current_key(const fs::path& project, const std::string& stage);

}  // namespace vitrine
