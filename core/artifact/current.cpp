#include "core/artifact/current.h"

#include "core/base/json.h"

namespace vitrine {

using nlohmann::json;

namespace {
fs::path current_file(const fs::path& project) { return store_of(project) / "current.json"; }

void write_keys(const fs::path& project, const std::map<std::string, std::string>& keys) {
  write_file(current_file(project), json(keys).dump(1) + "\n");
}
}  // namespace

fs::path store_of(const fs::path& project) { return project / ".cache"; }

std::map<std::string, std::string> current_keys(const fs::path& project) {
  std::map<std::string, std::string> keys;
  const fs::path file = current_file(project);
  std::error_code ec;
  if (!fs::exists(file, ec)) return keys;
  const json in = json::parse(read_file(file), nullptr, false);
  if (!in.is_object()) return keys;
  for (const auto& [stage, key] : in.items())
    if (key.is_string()) keys[stage] = key.get<std::string>();
  return keys;
}

std::optional<std::string> current_key(const fs::path& project, std::string_view stage) {
  const auto keys = current_keys(project);
  const auto found = keys.find(std::string(stage));
  return found == keys.end() ? std::nullopt : std::optional<std::string>(found->second);
}

void set_current_key(const fs::path& project, const std::string& stage, const std::string& key) {
  auto keys = current_keys(project);
  if (const auto found = keys.find(stage); found != keys.end() && found->second == key) return;
  keys[stage] = key;
  write_keys(project, keys);
}

void remove_current_key(const fs::path& project, const std::string& stage) {
  auto keys = current_keys(project);
  if (keys.erase(stage) > 0) write_keys(project, keys);
}

}  // namespace vitrine
