// Sections of the run: camera positions, photos without a pose and why, cost of each stage, warnings.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/terminal.h"
#include "pipeline/report_page/page.h"
#include "pipeline/report_page/pictures.h"
#include "pipeline/report_page/regions.h"

namespace vitrine {

namespace {

constexpr size_t kMostLeftOutPictures = 12;

std::string coverage_sentence(const ViewSet& views) {
  const auto ring = ring_coverage(views);
  if (!ring) return "The cameras look in much the same direction: they go along the scene, not around it.";
  const auto positive = [](double degrees) { return degrees < 0 ? degrees + 360 : degrees; };
  const double from = positive(ring->gap_from_deg), to = positive(std::fmod(ring->gap_from_deg + ring->gap_deg, 360));
  return fmt::format(
      "Around what they look at, the widest gap between neighbours is {:.0f}° (from {:.0f}° to {:.0f}°, counter-clockwise from "
      "the right of the "
      "plan); they stand {:.0f}° to {:.0f}° above it.",
      ring->gap_deg, from, to, ring->lowest_deg, ring->highest_deg);
}

std::string left_out(const Material& m) {
  std::string cells, rest;
  size_t n = 0;
  for (const PhotoPose& p : m.figures.photos) {
    if (p.registered) continue;
    const std::string reason = p.reason.empty() ? "no reason was written down" : p.reason;
    const fs::path file = m.project / "ingest/ldr" / (fs::path(p.name).replace_extension().generic_string() + ".png");
    const auto picture = stays_below(p.name) && n < kMostLeftOutPictures ? picture_of_file(file, kSmallPicture) : std::nullopt;
    ++n;
    if (picture)
      cells += fmt::format(
          "<figure><img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\"><figcaption><b>{}</b> "
          "{}</figcaption></figure>",
          picture->uri, picture->width, picture->height, escaped("Photo " + p.name), escaped(p.name), escaped(reason));
    else
      rest += fmt::format("<li><b>{}</b> {}</li>", escaped(p.name), escaped(reason));
  }
  if (n == 0) return {};
  std::string text = fmt::format("<h3>Left out: {} photo{}</h3>", n, n == 1 ? "" : "s");
  if (!cells.empty()) text += "<div class=\"grid\">" + cells + "</div>";
  if (!rest.empty()) text += "<ul>" + rest + "</ul>";
  return text;
}

std::string photo_table(const Material& m) {
  if (m.figures.photos.empty()) return {};
  std::string rows;
  for (const PhotoPose& p : m.figures.photos) {
    std::string psnr = "–";
    for (const PhotoScore& v : m.figures.views)
      if (v.name == p.name) psnr = fmt::format("{:.1f}{}", v.psnr, v.heldout ? " held out" : "");
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{:.0f}</td><td>{:.0f}</td><td>{}</td><td>{}</td></tr>", escaped(p.name),
                        p.features, p.matches, p.registered ? fmt::format("{:.0f}", p.observations) : "left out", psnr);
  }
  return fmt::format(
      "<details><summary>All {} photos</summary><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"All "
      "photos\"><table><thead><tr><th "
      "scope=\"col\">photo</th><th scope=\"col\">features</th><th scope=\"col\">verified matches</th><th scope=\"col\">points "
      "seen</th><th "
      "scope=\"col\">PSNR, dB</th></tr></thead><tbody>{}</tbody></table></div></details>",
      m.figures.photos.size(), rows);
}

}  // namespace

std::string cameras_section(const Material& m) {
  std::string body;
  if (m.views && !m.views->views.empty()) {
    body += fmt::format("<p>{}</p>", escaped(coverage_sentence(*m.views)));
    body += fmt::format(
        "<div "
        "class=\"drawings\"><figure>{}<figcaption>plan</figcaption></figure><figure>{}<figcaption>elevation</figcaption></"
        "figure></div>",
        plan_svg(*m.views, m.heldout), elevation_svg(*m.views, m.heldout));
    body += "<p class=\"legend\"><span class=\"key camera\"></span> training photo <span class=\"key heldout\"></span> held out";
    const auto ring = ring_coverage(*m.views);
    body += fmt::format("{}</p>", ring && ring->gap_deg >= kGapDrawnDeg ? " <span class=\"key gap\"></span> widest gap" : "");
  }
  body += left_out(m) + photo_table(m);
  return section(
      "cameras", "Cameras",
      "Where the photos were taken from, and what they have in common: small pyramids are cameras, dots are points that "
      "several photos share.",
      body);
}

std::string cost_section(const Material& m) {
  double longest = 0, total = 0, cpu = 0, peak = 0;
  for (const StageOutcome& s : m.outcome.stages) {
    longest = std::max(longest, s.seconds.value_or(0));
    total += s.seconds.value_or(0);
    cpu += s.cpu_seconds.value_or(0);
    peak = std::max(peak, s.peak_bytes.value_or(0));
  }
  if (m.outcome.stages.empty()) return {};
  const auto seconds = [](std::optional<double> v) { return v && *v > 0 ? duration_text(*v) : std::string("–"); };
  std::string rows, warnings;
  for (const StageOutcome& s : m.outcome.stages) {
    const bool stopped = s.state == "failed" && m.outcome.ending == Ending::Stopped;
    rows += fmt::format(
        "<li><span class=\"stage\">{}</span><span class=\"state\">{}</span><span class=\"length\" aria-hidden=\"true\"><i "
        "style=\"width:{:.1f}%\"></i></span>"
        "<span class=\"time\">{}</span><span class=\"cpu\">{}</span><span class=\"memory\">{}</span><span "
        "class=\"summary\">{}</span></li>",
        escaped(s.name), stopped ? "stopped" : escaped(s.state), longest > 0 ? 100 * s.seconds.value_or(0) / longest : 0.0,
        seconds(s.seconds), seconds(s.cpu_seconds) + (s.cpu_seconds.value_or(0) > 0 ? " CPU" : ""),
        s.peak_bytes && *s.peak_bytes > 0 ? bytes_text(size_t(*s.peak_bytes)) : std::string("–"), escaped(s.summary));
    for (const std::string& w : s.warnings) warnings += fmt::format("<li><b>{}</b> {}</li>", escaped(s.name), escaped(w));
  }
  std::string body = fmt::format("<ol class=\"stages\">{}</ol>", rows);
  if (total > 0)
    body += fmt::format(
        "<p class=\"facts\">Together {}, {} of CPU time, at most {} of memory{}. A stage that was not computed anew shows what "
        "it took when it was.</p>",
        duration_text(total), duration_text(cpu), bytes_text(size_t(peak)),
        m.outcome.machine.empty() ? "" : ", on " + escaped(m.outcome.machine));
  if (!warnings.empty()) body += fmt::format("<h3>Warnings</h3><ul class=\"warnings\">{}</ul>", warnings);
  return section("cost", "Time and memory", "", body);
}

}  // namespace vitrine
