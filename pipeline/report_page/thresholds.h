// Ratings (good, borderline, bad) by the thresholds that stages declare (core/foundation/artifact/stage_report.h), explained in README.md. A
// rating advises what to improve; the measured values are shown with it.
#pragma once

#include <string>
#include <string_view>

#include "core/foundation/artifact/stage_report.h"

namespace vitrine {

// Unknown: too few samples (figures.cpp); never returned by `rate`.
enum class Rating { Good, Borderline, Bad, Unknown };
std::string_view name(Rating rating);  // "good", "borderline", "bad", "unknown"

Rating rate(const ReportFigure& figure, double value);
// Position of the value on a scale of three equal parts bad | borderline | good, in [0,1]; clamped slightly inside the ends.
double place_on_scale(const ReportFigure& figure, double value);
std::string shown(const ReportFigure& figure, double value);  // "24.9 dB", "97 %"
std::string thresholds_text(const ReportFigure& figure);      // "good from 27 dB, borderline from 22 dB"

}  // namespace vitrine
