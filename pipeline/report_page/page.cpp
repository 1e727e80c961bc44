#include "pipeline/report_page/page.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "core/scene/camera/view_set.h"
#include "pipeline/report_page/assets.h"
#include "pipeline/report_page/facts.h"

namespace vitrine {

namespace {

constexpr std::string_view kStateMark = "<meta name=\"vitrine-state\" content=\"";
constexpr std::string_view kPageVersion = "3";

struct Chapter {
  const char *id, *title;
  std::string (*text)(const Material&);
};
constexpr Chapter kChapters[] = {
    {"figures", "Figures", figures_section}, {"views", "Photo against render", compare_section},
    {"regions", "Trust", regions_section},   {"layers", "Layers", layers_section},
    {"mesh", "Mesh", surface_section},       {"light", "Light", relit_section},
    {"cameras", "Cameras", cameras_section}, {"cost", "Time and memory", cost_section},
};

std::optional<ViewSet> read_view_set(const fs::path& project) {
  try {
    return load_view_set(project);
  } catch (const Error&) {
    return std::nullopt;  // no page yet
  }
}

Material read_material(const PageDesc& desc) {
  Material m;
  m.project = desc.project;
  m.outcome = read_outcome(desc.project);
  m.figures = gather_figures(desc.project, m.outcome);
  m.verdict = verdict_of(m.outcome, m.figures, desc.typed.empty() ? desc.project.string() : desc.typed);
  m.views = read_view_set(desc.project);
  for (const Facts& name : Facts::of_file(desc.project / "optimize/views.json").at("heldout").items())
    m.heldout.insert(name.text());
  return m;
}

// Content-security-policy digest of the only allowed script.
std::string script_digest() {
  const std::string hex = sha256_hex(kReportScript);
  std::string bytes;
  for (size_t i = 0; i < hex.size(); i += 2) bytes += char(std::stoi(hex.substr(i, 2), nullptr, 16));
  return "sha256-" + base64(bytes);
}

std::string head(const std::string& title, const std::string& state) {
  return fmt::format(
             "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{}{}\">\n"
             "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
             "'unsafe-inline'; script-src '{}'\">\n"
             "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" "
             "content=\"light dark\">\n"
             "<title>{}</title>\n<style>\n",
             kStateMark, state, script_digest(), escaped(title)) +
         std::string(kReportStyle) + "</style>\n</head>\n<body>\n";
}

}  // namespace

std::string page_state(const PageDesc& desc) {
  Hasher hash;
  hash.add(kPageVersion).add(kReportStyle).add(kReportScript).add(desc.typed);
  // run.json contains times that change with every run; only its outcome enters the digest.
  const RunOutcome outcome = read_outcome(desc.project);
  hash.add(uint64_t(outcome.ending)).add(uint64_t(outcome.exit)).add(outcome.preset).add(outcome.masks);
  if (outcome.failure) hash.add(outcome.failure->message).add(outcome.failure->why);
  hash.add(text_of_file(desc.project / ".cache/current.json"));
  std::error_code ec;
  std::vector<std::string> relit;
  for (fs::recursive_directory_iterator it(desc.project, ec), end; !ec && it != end; it.increment(ec)) {
    if (it.depth() >= 3 || it->path().filename() == ".cache") it.disable_recursion_pending();
    if (it->path().filename() == "settings.json") relit.push_back(it->path().lexically_relative(desc.project).generic_string());
  }
  std::sort(relit.begin(), relit.end());
  for (const std::string& file : relit) hash.add(file).add(text_of_file(desc.project / file));
  return hash.digest().hex();
}

std::string state_of_page(const fs::path& file) {
  const std::string text = text_of_file(file);
  const size_t begin = text.substr(0, 1024).find(kStateMark);
  if (begin == std::string::npos) return {};
  const size_t from = begin + kStateMark.size();
  return text.substr(from, text.find('"', from) - from);
}

std::string report_page(const PageDesc& desc) {
  const Material m = read_material(desc);
  const std::string name =
      desc.project.filename().empty() ? desc.project.parent_path().filename().string() : desc.project.filename().string();
  std::string chapters, links;
  for (const Chapter& c : kChapters) {
    const std::string text = c.text(m);
    if (text.empty()) continue;
    chapters += text;
    links += fmt::format("<a href=\"#{}\">{}</a>", c.id, c.title);
  }
  std::string line = escaped(name);
  const auto also = [&](const std::string& text) {
    if (!text.empty()) line += " <span aria-hidden=\"true\">·</span> " + escaped(text);
  };
  also(m.outcome.preset.empty() ? "" : "preset " + m.outcome.preset);
  also(m.outcome.finished.substr(0, 10));
  return head(fmt::format("{}: {}", name, m.verdict.word), page_state(desc)) +
         fmt::format("<header><p class=\"brand\">vitrine report</p><p class=\"run\">{}</p></header>\n<main>\n", line) +
         opening_section(m) + verdict_section(m) + (links.empty() ? "" : "<nav aria-label=\"Sections\">" + links + "</nav>\n") +
         chapters +
         fmt::format(
             "</main>\n<footer><p>Made by vitrine {} from the files of this folder. What each figure means: "
             "<code>eval/metrics.json</code>, "
             "<code>definitions</code>.</p></footer>\n<script>{}</script>\n</body>\n</html>\n",
             escaped(m.outcome.version), kReportScript);
}

}  // namespace vitrine
