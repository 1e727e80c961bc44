#include "core/scene/camera/passes.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"

namespace vitrine {

namespace {

fs::path passes_path(const fs::path& sfm_artifact) { return sfm_artifact / "sfm" / "passes.json"; }

constexpr const char* kPosesOf[] = {"object", "largest_pass", "surroundings"};
constexpr const char* kSummaries[] = {"the object was moved between them, and the poses are those of the object",
                                      "they share too little of the object, and the largest alone is reconstructed",
                                      "an object was moved between them, and the poses do not follow it: give masks of it"};

struct PassesFile {
  Passes passes;
  PosesOf poses = PosesOf::Object;
};

PassesFile read_file_of(const fs::path& sfm_artifact) {
  PassesFile file;
  if (const fs::path path = passes_path(sfm_artifact); fs::exists(path))
    read_json_file(path, "list of passes", [&](const nlohmann::json& j) {
      const auto word = std::find(std::begin(kPosesOf), std::end(kPosesOf), j.at("poses_of").get<std::string>());
      if (word == std::end(kPosesOf)) throw std::invalid_argument("poses_of must be object, largest_pass or surroundings");
      file.poses = PosesOf(word - std::begin(kPosesOf));
      for (const nlohmann::json& pass : j.at("passes")) file.passes.push_back(pass.at("photos").get<std::vector<std::string>>());
    });
  return file;
}

}  // namespace

Passes read_passes(const fs::path& sfm_artifact) {
  PassesFile file = read_file_of(sfm_artifact);
  return file.poses == PosesOf::Object ? std::move(file.passes) : Passes{};
}

void write_passes(const fs::path& sfm_artifact, const Passes& passes, PosesOf poses) {
  nlohmann::json list = nlohmann::json::array();
  for (const std::vector<std::string>& photos : passes) list.push_back({{"photos", photos}});
  write_json_file(passes_path(sfm_artifact), {{"poses_of", kPosesOf[size_t(poses)]}, {"passes", list}});
}

std::string passes_summary(const fs::path& sfm_artifact) {
  const PassesFile file = read_file_of(sfm_artifact);
  return file.passes.empty() ? std::string() : fmt::format("{}; {}", passes_text(file.passes), kSummaries[size_t(file.poses)]);
}

size_t pass_of(const Passes& passes, const std::string& photo) {
  for (size_t i = 0; i < passes.size(); ++i)
    if (std::find(passes[i].begin(), passes[i].end(), photo) != passes[i].end()) return i;
  return passes.size();
}

std::string passes_text(const Passes& passes) {
  std::string sizes;
  for (size_t i = 0; i < passes.size(); ++i)
    sizes += fmt::format("{}{}", i == 0 ? "" : i + 1 < passes.size() ? ", " : " and ", passes[i].size());
  return fmt::format("{} passes: {} photos", passes.size(), sizes);
}

}  // namespace vitrine
