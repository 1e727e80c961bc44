// An output folder (project): <project>/.cache is its store, .cache/current.json says which artifact of each stage is the one
// whose files are linked into the folder.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/file.h"

namespace vitrine {

fs::path store_of(const fs::path& project);
// stage -> key; empty when the folder is no project. A file that cannot be read counts as empty: it is rebuilt by the next run.
std::map<std::string, std::string> current_keys(const fs::path& project);
std::optional<std::string> current_key(const fs::path& project, std::string_view stage);
void set_current_key(const fs::path& project, const std::string& stage, const std::string& key);
void remove_current_key(const fs::path& project, const std::string& stage);

}  // namespace vitrine
