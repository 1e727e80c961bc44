#include "pipeline/farm/status.h"

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "core/foundation/base/terminal.h"
#include "pipeline/report_page/facts.h"
#include "pipeline/report_page/page.h"

namespace vitrine {

std::string FarmState::stage() const {
  if (done()) return "all";
  const std::string last = outcome.last_stage();
  return last.empty() ? "-" : last;
}

std::string FarmState::ending() const {
  switch (outcome.ending) {
    case Ending::Done:
      return "done";
    case Ending::Failed:
      return fmt::format("exit {}", outcome.exit);
    case Ending::Stopped:
      return "stopped, goes on when run again";
    case Ending::CutOff:
      return "running, or killed: goes on when run again";
    case Ending::Unknown:
      break;
  }
  std::error_code ec;
  return fs::exists(task.photos, ec) ? "not begun" : "its photos are gone: " + task.photos.string();
}

FarmState farm_state(const FarmTask& task) {
  FarmState state{.task = task, .outcome = read_outcome(task.project), .verdict = {}, .psnr = std::nullopt};
  for (const StageOutcome& s : state.outcome.stages) state.seconds += s.seconds.value_or(0);
  state.psnr = Facts::of_file(task.project / "eval" / "metrics.json").number("heldout.psnr");
  state.verdict = verdict_of(state.outcome, gather_figures(task.project, state.outcome), task.project.string());
  return state;
}

std::string farm_table(const std::vector<FarmState>& states) {
  size_t width = 7;
  for (const FarmState& s : states) width = std::max(width, s.task.capture.size());
  std::string text =
      fmt::format("{:>5} {:<{}} {:<10} {:>8} {:>6}  {}\n", "task", "capture", width, "stage", "took", "PSNR", "result");
  size_t done = 0;
  for (size_t i = 0; i < states.size(); ++i) {
    const FarmState& s = states[i];
    done += s.done();
    std::string result = s.ending();
    if (s.outcome.failure && !s.done()) result += ": " + s.outcome.failure->message;
    text += fmt::format("{:>5} {:<{}} {:<10} {:>8} {:>6}  {}\n", i + 1, s.task.capture, width, s.stage(),
                        s.seconds > 0 ? duration_text(s.seconds) : "-", s.psnr ? fmt::format("{:.1f}", *s.psnr) : "-",
                        s.done() ? s.verdict.word : result);
  }
  return text + fmt::format("{} of {} are done\n", done, states.size());
}

std::string farm_page(std::vector<FarmState> states, const fs::path& results) {
  // Failures first, then those that are not done, then by PSNR.
  const auto rank = [](const FarmState& s) {
    const int order = s.outcome.ending == Ending::Failed ? 0 : s.done() ? 2 : 1;
    return std::tuple(order, s.psnr.value_or(0), s.task.capture);
  };
  std::ranges::sort(states, {}, rank);
  std::string rows;
  for (const FarmState& s : states) {
    const std::string folder = fs::relative(s.task.project, results).generic_string();
    std::error_code ec;
    const auto link = [&](const char* file, const char* words) {
      if (!fs::exists(s.task.project / file, ec)) return std::string();
      return fmt::format("<a href=\"{0}/{1}\">{2}</a> ", escaped(folder), file, words);
    };
    std::string picture;
    for (const char* file : {"view_relit.jpg", "eval/contact_sheet.jpg"})
      if (picture.empty() && fs::exists(s.task.project / file, ec))
        picture = fmt::format("<img src=\"{}/{}\" alt=\"\" loading=\"lazy\">", escaped(folder), file);
    std::string sentence = s.done() ? s.verdict.word + ". " + s.verdict.sentence : s.ending();
    if (s.outcome.failure && !s.done()) sentence += ": " + s.outcome.failure->message;
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", picture,
                        escaped(s.task.capture), escaped(s.stage()), s.seconds > 0 ? escaped(duration_text(s.seconds)) : "",
                        s.psnr ? fmt::format("{:.1f}", *s.psnr) : "", escaped(sentence),
                        link("report.html", "report") + link("view.html", "page"));
  }
  return "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>vitrine farm</title>\n<style>body{font:15px "
         "sans-serif;margin:2em;background:#fff;color:#222}table{border-collapse:collapse}td,th{padding:.4em "
         ".8em;border-bottom:1px solid #ddd;text-align:left;vertical-align:top}img{width:10em}</style>\n<table>\n"
         "<tr><th></th><th>capture</th><th>stage</th><th>took</th><th>PSNR, dB</th><th>result</th><th></th></tr>\n" +
         rows + "</table>\n</html>\n";
}

}  // namespace vitrine
