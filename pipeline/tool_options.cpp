#include "pipeline/tool_options.h"

#include <fmt/format.h>

#include "core/foundation/base/error.h"

namespace vitrine {

void add_set_option(CommandLine& cli, ToolOptions& o, std::string_view tool) {
  cli.values("set", 0, "OPTION=VALUE", o.sets, fmt::format("An option of vitrine-{}.", tool));
}

void add_usual_options(CommandLine& cli, ToolOptions& o, std::string_view results) {
  cli.value("threads", 'j', "N", o.threads, 0, fmt::format("Threads; 0 = all. {} not depend on it.", results));
  cli.flag("no-progress", 0, o.no_progress, "No progress bar, no progress lines.");
  cli.flag("quiet", 'q', o.quiet, "Warnings and errors only.");
  cli.flag("help", 'h', o.help, "Print this text.");
}

const std::string& only_argument(const Words& rest, const char* question, const char* usage) {
  if (rest.size() != 1)
    throw Error(ErrorKind::Usage, rest.empty() ? std::string(question) : fmt::format("unexpected argument \"{}\"", rest[1]),
                {.hint = usage, .code = "USAGE"});
  return rest[0];
}

Words work_words(const ToolOptions& o) {
  Words words;
  for (const std::string& set : o.sets) words.insert(words.end(), {"--set", set});
  if (o.threads > 0) words.insert(words.end(), {"--threads", std::to_string(o.threads)});
  return words;
}

Words quietness(const ToolOptions& o) {
  Words words;
  if (o.no_progress) words.emplace_back("--no-progress");
  if (o.quiet) words.emplace_back("--quiet");
  return words;
}

}  // namespace vitrine
