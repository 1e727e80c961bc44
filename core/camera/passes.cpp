#include "core/camera/passes.h"

#include <fmt/format.h>

#include "core/base/file.h"
#include "core/camera/json_file.h"

namespace vitrine {

namespace {

fs::path passes_path(const fs::path& sfm_artifact) { return sfm_artifact / "sfm" / "passes.json"; }

}  // namespace

Passes read_passes(const fs::path& sfm_artifact) {
  const fs::path path = passes_path(sfm_artifact);
  Passes passes;
  if (!fs::exists(path)) return passes;
  read_json_file(path, "list of passes", [&](const nlohmann::json& j) {
    for (const nlohmann::json& pass : j.at("passes")) passes.push_back(pass.at("photos").get<std::vector<std::string>>());
  });
  return passes;
}

void write_passes(const fs::path& sfm_artifact, const Passes& passes) {
  nlohmann::json list = nlohmann::json::array();
  for (const std::vector<std::string>& photos : passes) list.push_back({{"photos", photos}});
  write_json_file(passes_path(sfm_artifact), {{"passes", list}});
}

std::string passes_text(const Passes& passes) {
  std::string sizes;
  for (size_t i = 0; i < passes.size(); ++i)
    sizes += fmt::format("{}{}", i == 0 ? "" : i + 1 < passes.size() ? ", " : " and ", passes[i].size());
  return fmt::format("{} passes: {} photos", passes.size(), sizes);
}

}  // namespace vitrine
