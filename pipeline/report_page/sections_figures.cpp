// Sections: verdict, rated figures, reliability of each kind of surface.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "core/foundation/base/terminal.h"
#include "pipeline/report_page/facts.h"
#include "pipeline/report_page/page.h"

namespace vitrine {

namespace {

constexpr size_t kMostAdvice = 3;
constexpr std::array<std::string_view, 4> kSigns = {"●", "◐", "○", "?"};  // ratings must not depend on colour alone

std::string figure_row(const Figure& f) {
  const ReportFigure& r = f.rule;
  std::string text =
      fmt::format("<li class=\"figure\"><div class=\"what\"><h4>{}</h4><p>{}</p>", escaped(r.label), escaped(r.means));
  if (f.rating == Rating::Unknown)
    text += fmt::format("<p class=\"why\">Unknown: {}.</p>", escaped(f.unknown));
  else if (f.rating != Rating::Good)
    text += fmt::format("<p class=\"why\">{}</p>", escaped(r.weak));
  if (!f.note.empty()) text += fmt::format("<p class=\"note\">{}</p>", escaped(f.note));
  std::string scale;
  if (f.rating != Rating::Unknown)
    scale = fmt::format("<span class=\"scale\" aria-hidden=\"true\"><i style=\"left:{:.0f}%\"></i></span>",
                        100 * place_on_scale(r, f.value));
  text += fmt::format("</div><div class=\"value\"><span class=\"number\">{}</span>{}{}<small>{}</small></div></li>",
                      escaped(shown(r, f.value)), rating_badge(f.rating), scale, escaped(thresholds_text(r)));
  return text;
}

// Wraps commands between words only, never at the hyphens of options.
std::string command_block(const std::string& command) {
  std::string words;
  for (char c : escaped(command)) words += c == ' ' ? std::string("</span> <span>") : std::string(1, c);
  return "<code class=\"command\"><span>" + words + "</span></code>";
}

std::string decibels(const std::optional<double>& v) { return v ? fmt::format("{:.1f}\u00a0dB", *v) : std::string("–"); }

std::string trust_word(Rating rating) {
  return rating == Rating::Good ? "high" : rating == Rating::Borderline ? "medium" : "low";
}

std::string object_table(const Material& m) {
  std::string rows;
  for (const Facts& o : Facts::of_file(m.project / "eval/metrics.json").at("objects").items()) {
    const auto iou = o.number("iou");
    std::string role = o.text("role");
    std::ranges::replace(role, '_', ' ');
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>", escaped(o.text("name")),
                        escaped(role), escaped(o.text("trust")), decibels(o.number("psnr")),
                        iou ? fmt::format("{:.0f}\u00a0%", 100 * *iou) : std::string("–"));
  }
  if (rows.empty()) return {};
  return "<h3>Objects</h3><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Objects\"><table><thead><tr>"
         "<th scope=\"col\">object</th><th scope=\"col\">role</th><th scope=\"col\">outlines</th><th scope=\"col\">new "
         "views</th><th scope=\"col\">surfels and labels overlap</th></tr></thead><tbody>" +
         rows + "</tbody></table></div>";
}

}  // namespace

std::string section(std::string_view id, std::string_view title, std::string_view lead, const std::string& body) {
  if (body.empty()) return {};
  return fmt::format("<section id=\"{}\"><h2>{}</h2>{}{}</section>\n", id, title,
                     lead.empty() ? std::string() : fmt::format("<p class=\"lead\">{}</p>", lead), body);
}

std::string rating_badge(Rating rating) {
  return fmt::format("<span class=\"rating {0}\"><span aria-hidden=\"true\">{1}</span> {0}</span>", name(rating),
                     kSigns[size_t(rating)]);
}

std::string verdict_section(const Material& m) {
  constexpr std::array<std::string_view, 4> kClasses = {"good", "borderline", "bad", "unfinished"};
  const Verdict& v = m.verdict;
  std::string text = fmt::format("<section id=\"verdict\" class=\"{}\"><h1>{}.</h1><p class=\"sentence\">{}</p>",
                                 kClasses[size_t(v.mood)], escaped(v.word), escaped(v.sentence));
  if (!v.weak.empty()) {
    text +=
        fmt::format("<div class=\"columns\"><div><h2>{}</h2><ul>", m.outcome.ending == Ending::Failed ? "Why" : "What is weak");
    for (const WeakSpot& w : v.weak)
      text += fmt::format("<li>{}{}</li>", escaped(w.text),
                          w.figure.empty() ? std::string() : fmt::format("<small class=\"by\">{}</small>", escaped(w.figure)));
    text += "</ul></div>";
  } else {
    text += "<div class=\"columns\">";
  }
  text += "<div><h2>Try next</h2><ol>";
  for (size_t i = 0; i < std::min(v.next.size(), std::max(kMostAdvice, m.outcome.failure ? v.next.size() : 0)); ++i) {
    text += fmt::format("<li>{}", escaped(v.next[i].text));
    // A command that two pieces of advice share is shown once.
    const bool before = i > 0 && v.next[i].command == v.next[i - 1].command;
    if (!v.next[i].command.empty() && !before) text += command_block(v.next[i].command);
    text += "</li>";
  }
  text += "</ol></div></div>";
  if (m.outcome.ending != Ending::Done && m.figures.find("psnr") != nullptr)
    text += "<p class=\"note\">Figures and pictures below are of what earlier runs left in this folder.</p>";
  return text + "</section>\n";
}

std::string figures_section(const Material& m) {
  std::string body;
  for (const FigureGroup& group : m.figures.groups) {
    body += fmt::format("<div class=\"group\"><h3>{}</h3><ul class=\"figures\">", escaped(group.title));
    for (const Figure& f : group.figures) body += figure_row(f);
    body += "</ul></div>";
  }
  if (!m.figures.facts.empty()) {
    body += "<p class=\"facts\">Made of: ";
    for (size_t i = 0; i < m.figures.facts.size(); ++i) body += (i > 0 ? "; " : "") + escaped(m.figures.facts[i]);
    body += ".</p>";
  }
  return section("figures", "Figures", "Ratings show what is worth doing next; the figures themselves are measurements.", body);
}

std::string regions_section(const Material& m) {
  if (!m.views) return {};
  const std::vector<RegionTrust> regions = region_trust(m.project, *m.views, m.figures);
  std::string body;
  for (const RegionTrust& r : regions) {
    if (!r.trust) continue;
    body += fmt::format(
        "<article class=\"region\"><h3>{}</h3><p class=\"trust {}\"><span aria-hidden=\"true\">{}</span> {} "
        "confidence</p><p>{}.</p><dl>",
        escaped(r.title), name(*r.trust), kSigns[size_t(*r.trust)], trust_word(*r.trust), escaped(r.why));
    const auto row = [&](std::string_view term, const std::string& value) {
      body += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", term, value);
    };
    row("share of the pictures", fmt::format("{:.0f}\u00a0%", 100 * r.share));
    row("new views", decibels(r.psnr));
    row("training views", decibels(r.train_psnr));
    row("sparse points per tenth of a photo", fmt::format("{:.0f}", r.points));
    if (r.views_per_point) row("photos per point", fmt::format("{:.0f}", *r.views_per_point));
    if (r.normals_confidence) row("confidence of the normals", fmt::format("{:.2f}", *r.normals_confidence));
    body += "</dl></article>";
  }
  if (!body.empty()) body = "<div class=\"regions\">" + body + "</div>";
  body += object_table(m);
  return section("regions", "What can be trusted",
                 "Per kind of surface: how it is drawn from new places, and how much the photos know of it.", body);
}

}  // namespace vitrine
