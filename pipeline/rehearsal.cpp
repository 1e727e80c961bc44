#include "pipeline/tool.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "pipeline/commands.h"

namespace vitrine {

namespace {

// Sufficient for a few hundred features per photo, which the check of given poses needs; twelve photos take two seconds.
constexpr const char* kSmall[] = {"ingest.max_side=800", "sfm.max_features=2048"};

// Merges warnings of one code into one finding: "(and 11 more)".
void add(std::vector<RunMessage>& list, std::vector<size_t>& more, RunMessage message) {
  for (size_t i = 0; i < list.size(); ++i)
    if (!message.error && !list[i].error && list[i].code == message.code) {
      ++more[i];
      return;
    }
  list.push_back(std::move(message));
  more.push_back(0);
}

}  // namespace

std::vector<RunMessage> rehearsed(const RehearsalDesc& desc) {
  if (desc.poses.empty() || desc.poses == "none") return {};
  const TemporaryFolder folder("vitrine-rehearsal");
  Words words = {fs::read_symlink("/proc/self/exe").string(),
                 "run",
                 desc.photos.string(),
                 "-o",
                 (folder.path() / "out").string(),
                 "--poses",
                 desc.poses,
                 "--preset",
                 "preview",
                 "--to",
                 "sfm",
                 "--no-preflight",
                 "--log-format",
                 "json"};
  for (const char* set : kSmall) words.insert(words.end(), {"--set", set});
  if (!desc.masks.empty()) words.insert(words.end(), {"--masks", desc.masks});
  if (desc.threads > 0) words.insert(words.end(), {"--threads", std::to_string(desc.threads)});
  std::vector<RunMessage> list;
  std::vector<size_t> more;
  run_process(
      {.arguments = words, .on_line = [&](std::string_view line) {
         if (!line.starts_with("{\"v\"")) return;
         const nlohmann::json record = nlohmann::json::parse(line, nullptr, false);
         if (!record.is_object()) return;
         const std::string type = record.value("type", "");
         if (type == "warning") add(list, more, {.code = record.value("code", ""), .what = record.value("text", "")});
         if (type == "error")
           add(list, more,
               {.error = true,
                .code = record.value("code", ""),
                .what = record.value("message", ""),
                .why = record.value("where", "") + (record.value("why", "").empty() ? "" : ": " + record.value("why", "")),
                .hint = record.value("hint", "")});
       }});
  throw_if_interrupted();
  for (size_t i = 0; i < list.size(); ++i)
    if (more[i] > 0) list[i].what += fmt::format(" (and {} more such warnings)", more[i]);
  std::ranges::stable_sort(list, [](const RunMessage& a, const RunMessage& b) { return a.error > b.error; });
  return list;
}

}  // namespace vitrine
