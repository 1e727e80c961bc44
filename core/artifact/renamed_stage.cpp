#include "core/artifact/renamed_stage.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/artifact/current.h"
#include "core/artifact/publish.h"
#include "core/artifact/store.h"
#include "core/base/error.h"

namespace vitrine {

namespace {

// The roles of a program in current.json: "relit", and "relit-edited" for its pictures of the edited scene.
bool is_role_of(std::string_view role, std::string_view stage) {
  return role == stage || (role.starts_with(stage) && role.substr(stage.size()).starts_with("-"));
}

std::string with_head(std::string_view text, std::string_view before, std::string_view now) {
  return fmt::format("{}{}", now, text.substr(before.size()));
}

// Its files tell the old meaning of a name from the new one.
bool is_of_before(const Manifest& m, const RenamedStage& r) {
  const std::string head = fmt::format("{}/", r.before);
  return m.stage == r.before &&
         std::all_of(m.outputs.begin(), m.outputs.end(), [&](const OutputFile& f) { return f.path.starts_with(head); });
}

KeyTerms terms_now(const KeyTerms& before, const RenamedStage& r) {
  KeyTerms terms;
  for (const auto& [term, value] : before) {
    std::string name = term;
    for (const RenamedStage& input : kRenamedStages)
      if (term == fmt::format("input.{}", input.before)) name = fmt::format("input.{}", input.now);
    terms[name] = value;
  }
  terms["stage"] = r.now;
  return terms;
}

std::string timing_of(const fs::path& entry) {
  std::error_code ec;
  return fs::exists(entry / kTimingName, ec) ? read_file(entry / kTimingName) : "{}\n";
}

// Links the artifact under its new name; returns its manifest.
Manifest linked(ArtifactStore& store, const Manifest& before, const RenamedStage& r) {
  Manifest now = before;
  now.stage = r.now;
  now.terms = terms_now(before.terms, r);
  now.key = key_of(now.terms);
  const fs::path from = store.entry(r.before, before.key);
  PendingArtifact pending(store, r.now, now.key);
  for (const OutputFile& file : before.outputs)
    link_or_copy(from / file.path, pending.path() / with_head(file.path, r.before, r.folder));
  pending.commit(now, timing_of(from));
  return now;
}

std::optional<Manifest> found(ArtifactStore& store, const RenamedStage& r, const std::string& key) {
  try {
    return store.find(r.before, key);
  } catch (const Error&) {
    return std::nullopt;  // unreadable
  }
}

// Empty: the role has not moved.
std::string adopt(const fs::path& project, ArtifactStore& store, const RenamedStage& r, const std::string& role,
                  const std::string& key) {
  const auto before = found(store, r, key);
  if (before && !is_of_before(*before, r)) return {};
  if (before && store.damage(store.entry(r.before, key)).empty()) {
    const Manifest now = linked(store, *before, r);
    if (r.folder != r.before) {
      publish(store.entry(r.now, now.key), now, project, &*before);
      std::error_code ec;
      fs::remove(project / r.before, ec);  // succeeds only when empty
    }
    set_current_key(project, with_head(role, r.before, r.now), now.key);
  }
  remove_current_key(project, role);
  return fmt::format(
      "the stage '{}' of the version before is called '{}' now; its results in this folder are kept under that name", r.before,
      r.now);
}

}  // namespace

std::string_view stage_name_before(std::string_view now) {
  for (const RenamedStage& r : kRenamedStages)
    if (r.now == now) return r.before;
  return {};
}

bool is_name_of_another_now(std::string_view before) { return !stage_name_before(before).empty(); }

std::string renamed_stage_message(std::string_view before, std::string_view now) {
  return fmt::format("'{}' is called '{}' now; the old name is accepted in this version alone", before, now);
}

bool has_results_of_renamed_stages(const fs::path& project) {
  const auto keys = current_keys(project);
  return std::any_of(std::begin(kRenamedStages), std::end(kRenamedStages), [&](const RenamedStage& r) {
    return !keys.contains(std::string(r.now)) &&
           std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return is_role_of(key.first, r.before); });
  });
}

std::vector<std::string> adopt_results_of_renamed_stages(const fs::path& project) {
  std::vector<std::string> lines;
  ArtifactStore store(store_of(project));
  for (const RenamedStage& r : kRenamedStages)
    for (const auto& [role, key] : current_keys(project)) {
      if (!is_role_of(role, r.before) || current_key(project, with_head(role, r.before, r.now))) continue;
      std::string line = adopt(project, store, r, role, key);
      if (!line.empty() && role == r.before) lines.push_back(std::move(line));
    }
  return lines;
}

}  // namespace vitrine
