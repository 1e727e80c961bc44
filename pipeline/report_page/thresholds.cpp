#include "pipeline/report_page/thresholds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

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

}  // namespace

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
