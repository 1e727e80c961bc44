#include "pipeline/project.h"

#include <algorithm>
#include <optional>
#include <set>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;
using Names = std::set<std::string>;  // of files, relative to the export folder

constexpr std::string_view kFolder = "export/";       // of the artifact
constexpr std::string_view kReport = "formats.json";  // list of formats and their files

fs::path exported_list(const fs::path& project) { return store_of(project) / "exported.json"; }

// Existing files that `vitrine export` wrote into PROJECT/export.
Names exported_files(const fs::path& project) {
  Names names;
  std::error_code ec;
  if (!fs::exists(exported_list(project), ec)) return names;
  const Json json = Json::parse(read_file(exported_list(project)), nullptr, false);
  if (!json.is_array()) return names;
  for (const Json& name : json)
    if (name.is_string() && fs::exists(project / kFolder / name.get<std::string>(), ec)) names.insert(name.get<std::string>());
  return names;
}

bool same_bytes(const fs::path& a, const fs::path& b) {
  std::error_code ec;
  return fs::is_regular_file(a, ec) && fs::is_regular_file(b, ec) && fs::file_size(a) == fs::file_size(b) &&
         (fs::equivalent(a, b, ec) || read_file(a) == read_file(b));
}

// Reads formats.json; nullopt if it is missing or not written by vitrine.
std::optional<Json> read_formats(const fs::path& path) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec)) return std::nullopt;
  Json json = Json::parse(read_file(path), nullptr, false);
  const bool ours = json.is_array() && std::ranges::all_of(json, [](const Json& f) {
                      if (!f.is_object() || !f.contains("format") || !f["format"].is_string()) return false;
                      if (!f.contains("files") || !f["files"].is_array()) return false;
                      return std::ranges::all_of(f["files"], [](const Json& name) { return name.is_string(); });
                    });
  return ours ? std::optional<Json>(std::move(json)) : std::nullopt;
}

bool writes_any(const Json& format, const Names& names) {
  return std::ranges::any_of(format["files"], [&](const Json& file) { return names.contains(file.get<std::string>()); });
}

const Json* find_format(const Json& report, const Json& name) {
  const auto it = std::ranges::find_if(report, [&](const Json& f) { return f["format"] == name; });
  return it == report.end() ? nullptr : &*it;
}

void write_report(const fs::path& path, const Json& report) {
  write_file(path, report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

Names names_of(const Manifest& manifest) {
  Names names;
  for (const OutputFile& f : manifest.outputs) {
    VITRINE_CHECK(f.path.starts_with(kFolder), "the export stage wrote {}", f.path);
    names.insert(f.path.substr(kFolder.size()));
  }
  return names;
}

// Updates the list of exported files. Files identical to those of the run's export are removed: the next run may replace them.
void record_exported(const fs::path& project, const fs::path& entry, const Names& names) {
  Names exported = exported_files(project);
  const auto current = current_key(project, kExportStage);
  const fs::path of_run = current ? store_of(project) / kExportStage / *current / kFolder : fs::path();
  for (const std::string& name : names)
    if (name == kReport || (current && same_bytes(entry / kFolder / name, of_run / name)))
      exported.erase(name);
    else
      exported.insert(name);
  write_file(exported_list(project), Json(exported).dump(1) + "\n");
}

}  // namespace

void put_export(const fs::path& entry, const Manifest& manifest, const ExportDesc& desc) {
  const Names names = names_of(manifest);
  const std::optional<Json> existing = read_formats(desc.target / kReport);
  std::vector<std::string> conflicts;
  std::error_code ec;
  for (const std::string& name : names) {
    const fs::path there = desc.target / name;
    if (!fs::exists(fs::symlink_status(there, ec))) continue;
    // formats.json grows with every export.
    if (name == kReport ? !existing : !same_bytes(entry / kFolder / name, there)) conflicts.push_back(name);
  }
  if (!conflicts.empty() && !desc.overwrite) {
    std::string list;
    constexpr size_t kNamed = 5;
    for (size_t i = 0; i < std::min(kNamed, conflicts.size()); ++i) list += (i > 0 ? ", " : "") + conflicts[i];
    if (conflicts.size() > kNamed) list += ", ...";
    throw Error(ErrorKind::Input, "nothing was exported: files with other contents are in the way",
                {.where = desc.target.string(),
                 .why = fmt::format("{} would be replaced: {}", conflicts.size(), list),
                 .hint = "--overwrite, or another folder with -o",
                 .code = "EXPORT_EXISTS"});
  }
  // Written before the files, so that after a kill the files are still listed as exported.
  if ((desc.target / "").lexically_normal() == (desc.project / kFolder).lexically_normal())
    record_exported(desc.project, entry, names);
  for (const std::string& name : names) {
    const fs::path from = entry / kFolder / name, to = desc.target / name;
    if (name != kReport && !same_bytes(from, to)) link_or_copy(from, to);
  }
  // Formats in the existing report are kept unless this export rewrote them.
  const Json fresh = Json::parse(read_file(entry / kFolder / kReport));
  Json report = Json::array();
  if (existing)
    for (const Json& old : *existing)
      if (find_format(fresh, old["format"]) == nullptr) report.push_back(old);
  for (const Json& format : fresh) report.push_back(format);
  write_report(desc.target / kReport, report);
}

std::vector<std::string> publish_export(const fs::path& entry, const Manifest& manifest, const fs::path& project,
                                        const Manifest* before) {
  const Names exported = exported_files(project);
  const std::optional<Json> existing = exported.empty() ? std::nullopt : read_formats(project / kFolder / kReport);
  if (exported.empty()) {
    publish(entry, manifest, project, before);
    return {};
  }
  const Json fresh = Json::parse(read_file(entry / kFolder / kReport));
  std::set<std::string> kept;  // paths in the artifact
  Json report = Json::array();
  std::vector<std::string> formats;
  std::error_code ec;
  for (const Json& format : fresh) {
    if (!writes_any(format, exported)) {
      report.push_back(format);
      continue;
    }
    const Json* old = existing ? find_format(*existing, format["format"]) : nullptr;
    report.push_back(old ? *old : format);
    formats.push_back(format["format"].get<std::string>());
    for (const Json& file : format["files"])
      if (fs::exists(project / kFolder / file.get<std::string>(), ec))
        kept.insert(std::string(kFolder) + file.get<std::string>());
  }
  if (existing)
    for (const Json& old : *existing)
      if (find_format(fresh, old["format"]) == nullptr && writes_any(old, exported)) report.push_back(old);
  kept.insert(std::string(kFolder) + std::string(kReport));
  publish(entry, manifest, project, before, kept);
  write_report(project / kFolder / kReport, report);
  return formats;
}

}  // namespace vitrine
