#include "core/foundation/artifact/publish.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"

namespace vitrine {

void publish(const fs::path& entry, const Manifest& manifest, const fs::path& folder, const Manifest* before,
             const std::set<std::string>& kept) {
  std::error_code ec;
  if (before != nullptr) {
    std::set<std::string> stay = kept;
    for (const OutputFile& file : manifest.outputs) stay.insert(file.path);
    for (const OutputFile& old : before->outputs) {
      const fs::path target = folder / old.path;
      const bool ours = !stay.contains(old.path) && fs::is_regular_file(target, ec) && fs::file_size(target, ec) == old.bytes &&
                        digest_file(target).hex() == old.digest;
      if (ours) fs::remove(target, ec);
      fs::remove(target.parent_path(), ec);  // succeeds only when empty
    }
  }
  for (const OutputFile& file : manifest.outputs) {
    if (kept.contains(file.path)) continue;
    const fs::path from = entry / file.path, to = folder / file.path;
    if (!fs::equivalent(from, to, ec)) link_or_copy(from, to);
  }
}

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
