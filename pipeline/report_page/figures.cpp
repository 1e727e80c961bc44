#include "pipeline/report_page/figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/math/median.h"
#include "pipeline/graph.h"
#include "pipeline/report_page/facts.h"

namespace vitrine {

namespace {

// Fractions are shown in percent.
std::string number_text(const ReportFigure& figure, double value, int decimals) {
  const bool percent = figure.unit == "%";
  std::string text = fmt::format("{:.{}f}", percent ? 100 * value : value, decimals);
  if (figure.unit.empty()) return text;
  return text + "\u00a0" + figure.unit;
}

std::string limit_text(const ReportFigure& figure, double limit) {
  const double value = figure.unit == "%" ? 100 * limit : limit;
  std::string text = fmt::format("{:g}", value);
  return figure.unit.empty() ? text : text + "\u00a0" + figure.unit;
}

// Order in the page; other groups follow in the order of the stages.
constexpr std::string_view kGroups[] = {"Photos and poses", "Pictures from new places", "Parts of the picture",
                                        "Geometry",         "Light and materials",      "Against the truth"};
// The figure that comes with a list of the photos.
constexpr std::string_view kOfPhotos = "registered";

// Sentence for the reason of a missing pose, a code of the sfm report (stages/sfm/README.md).
std::string reason_of(const Facts& photo) {
  constexpr std::pair<std::string_view, std::string_view> kCauses[] = {
      {"mixed_exposure", "much brighter or darker than the others"},
      {"motion_blur", "blurred"},
      {"too_few_features", "too little texture"},
      {"split_models", "part of another group of photos"},
      {"reflections_dominate", "mostly reflections"},
      {"no_overlap", "too little in common with the others"}};
  const std::string reason = photo.text("reason"), cause = photo.text("cause");
  for (const auto& [name, words] : kCauses)
    if (name == cause) return reason.empty() ? std::string(words) : fmt::format("{} (likely: {})", reason, words);
  return reason;
}

std::vector<PhotoPose> read_photos(const Facts& sfm) {
  std::vector<PhotoPose> photos;
  for (const Facts& p : sfm.at("photos").items())
    photos.push_back({.name = p.text("name"),
                      .reason = reason_of(p),
                      .registered = p.boolean("registered").value_or(false),
                      .features = p.number("features").value_or(0),
                      .matches = p.number("verified_matches").value_or(0),
                      .observations = p.number("observations").value_or(0)});
  return photos;
}

std::vector<PhotoScore> read_views(const fs::path& project) {
  constexpr std::string_view kPrefix = "psnr_";
  std::vector<PhotoScore> views;
  for (const auto& row : rows_of_csv(text_of_file(project / "eval/per_view.csv"))) {
    const auto cell = [&](const char* name) {
      const auto found = row.find(name);
      return found == row.end() ? std::string() : found->second;
    };
    const auto psnr = number_of(cell("psnr"));
    if (!psnr || cell("name").empty()) continue;
    PhotoScore& v = views.emplace_back();
    v.name = cell("name");
    v.heldout = cell("set") == "heldout";
    v.psnr = *psnr;
    v.ssim = number_of(cell("ssim"));
    for (const auto& [key, text] : row)
      if (const auto region = number_of(text); region && key.starts_with(kPrefix))
        v.regions[key.substr(kPrefix.size())] = *region;
  }
  return views;
}

const PhotoScore* weakest_view(const std::vector<PhotoScore>& views) {
  const PhotoScore* weakest = nullptr;
  for (const PhotoScore& v : views)
    if (v.heldout && (weakest == nullptr || v.psnr < weakest->psnr)) weakest = &v;
  return weakest;
}

// Reduces a non-empty list of values.
double folded(const std::string& how, const std::vector<std::pair<std::string, double>>& numbers) {
  std::vector<double> values;
  double sum = 0;
  for (const auto& [name, n] : numbers) values.push_back(n), sum += n;
  return how == "median" ? upper_median(std::move(values)) : how == "last" ? values.back() : sum / double(values.size());
}

std::optional<double> value_of(const ReportFigure& rule, const Facts& report) {
  const auto numbers = numbers_at(report, rule.value, rule.where);
  if (numbers.empty()) return std::nullopt;
  const double value = folded(rule.fold, numbers);
  const auto less = report.number(rule.minus), whole = report.number(rule.over);
  if (!rule.minus.empty()) return less ? std::optional(value - *less) : std::nullopt;
  if (!rule.over.empty()) return whole && *whole > 0 ? std::optional(value / *whole) : std::nullopt;
  return value;
}

std::optional<Figure> figure_of(const ReportFigure& rule, const Facts& report, const std::vector<PhotoScore>& views) {
  std::optional<double> value = value_of(rule, report);
  const double samples =
      rule.samples.empty() ? NAN : report.number(rule.samples).value_or(NAN);  // NaN if the report has no count
  if (rule.shown_without && samples <= 0) value = NAN;
  Figure f{.rule = rule, .value = 0, .rating = Rating::Unknown, .note = fact_text(rule.note, report).value_or(""), .unknown = {}};
  if (rule.fold == "above_weakest_view") {
    const PhotoScore* weakest = weakest_view(views);
    if (!value || weakest == nullptr || !(samples >= rule.fewest)) return std::nullopt;
    f.note = fmt::format("{}: {:.1f} dB", weakest->name, weakest->psnr);
    value = std::max(0.0, *value - weakest->psnr);
  }
  if (!value) return std::nullopt;
  f.value = *value;
  if (samples < rule.fewest)
    f.unknown = fmt::format("too few {} ({:.0f})", rule.counted, samples);
  else
    f.rating = rate(rule, *value);
  return f;
}

std::vector<std::string> group_titles() {
  std::vector<std::string> titles(std::begin(kGroups), std::end(kGroups));
  const auto add = [&](const std::string& title) {
    if (std::ranges::find(titles, title) == titles.end()) titles.push_back(title);
  };
  for (const DeclaredReport& declared : declared_reports()) {
    for (const ReportFigure& figure : declared.report.figures) add(figure.group);
    for (const ReportFact& fact : declared.report.facts) add(fact.group);
  }
  return titles;
}

std::optional<std::string> text_of(const ReportFact& fact, const Facts& report) {
  if (fact.each.empty()) return fact_text(fact.text, report);
  for (const Facts& item : report.at(fact.each).items())
    if (auto text = fact_text(fact.text, item)) return text;
  return std::nullopt;
}

}  // namespace

const Figure* Figures::find(std::string_view id) const {
  for (const FigureGroup& group : groups)
    for (const Figure& figure : group.figures)
      if (figure.rule.id == id) return &figure;
  return nullptr;
}

const std::vector<DeclaredReport>& declared_reports() {
  static const std::vector<DeclaredReport> reports = [] {
    std::vector<DeclaredReport> all;
    try {
      for (const StageNode& node : load_graph(stage_folder()).nodes) all.push_back({node.name, node.doing, node.report});
    } catch (const Error&) {  // the page is written without figures
    }
    return all;
  }();
  return reports;
}

const ReportFigure* declared_figure(std::string_view id) {
  for (const DeclaredReport& declared : declared_reports())
    for (const ReportFigure& figure : declared.report.figures)
      if (figure.id == id) return &figure;
  return nullptr;
}

Figures gather_figures(const fs::path& project, const RunOutcome& outcome) {
  Figures f;
  f.views = read_views(project);
  std::vector<Facts> reports;
  for (const DeclaredReport& d : declared_reports()) {
    reports.push_back(d.report.file.empty() ? Facts() : Facts::of_file(outcome.report_of(project, d.stage, d.report.file)));
    if (std::ranges::find(d.report.figures, kOfPhotos, &ReportFigure::id) != d.report.figures.end())
      f.photos = read_photos(reports.back());
  }
  std::set<std::string> reported;
  for (const std::string& title : group_titles()) {
    FigureGroup group{.title = title, .figures = {}};
    for (size_t s = 0; s < reports.size(); ++s) {
      for (const ReportFigure& rule : declared_reports()[s].report.figures)
        if (auto figure = rule.group == title ? figure_of(rule, reports[s], f.views) : std::nullopt)
          group.figures.push_back(std::move(*figure));
      for (const ReportFact& fact : declared_reports()[s].report.facts)
        if (auto text = fact.group == title && !reported.contains(fact.once) ? text_of(fact, reports[s]) : std::nullopt) {
          f.facts.push_back(std::move(*text));
          if (!fact.once.empty()) reported.insert(fact.once);
        }
    }
    if (!group.figures.empty()) f.groups.push_back(std::move(group));
  }
  return f;
}

std::string_view name(Rating rating) {
  constexpr std::array<std::string_view, 4> kNames = {"good", "borderline", "bad", "unknown"};
  return kNames[size_t(rating)];
}

Rating rate(const ReportFigure& r, double value) {
  const double sign = r.higher_is_better() ? 1 : -1;
  if (sign * value >= sign * r.good) return Rating::Good;
  return sign * value >= sign * r.fair ? Rating::Borderline : Rating::Bad;
}

double place_on_scale(const ReportFigure& r, double value) {
  constexpr double kMargin = 0.03;
  return std::clamp((1 + (value - r.fair) / (r.good - r.fair)) / 3, kMargin, 1 - kMargin);
}

std::string shown(const ReportFigure& r, double value) {
  return std::isfinite(value) ? number_text(r, value, r.decimals) : std::string("–");
}

std::string thresholds_text(const ReportFigure& r) {
  const std::string_view word = r.higher_is_better() ? "from" : "up to";
  return fmt::format("good {} {}, borderline {} {}", word, limit_text(r, r.good), word, limit_text(r, r.fair));
}

}  // namespace vitrine
