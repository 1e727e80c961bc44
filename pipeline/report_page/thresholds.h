// When a figure is good, borderline or bad, by the limits that its stage declares (core/artifact/stage_report.h); explained in
// README.md. A rating is an opinion about what to do next, not a measurement: the figures stand beside it.
#pragma once

#include <string>
#include <string_view>

#include "core/artifact/stage_report.h"

namespace vitrine {

// Unknown: measured on too little to say (figures.cpp); `rate` never gives it.
enum class Rating { Good, Borderline, Bad, Unknown };
std::string_view name(Rating rating);  // "good", "borderline", "bad", "unknown"

Rating rate(const ReportFigure& figure, double value);
// Where the value stands on a scale of three equal parts bad | borderline | good, in [0,1]; beyond the ends it stays just inside.
double place_on_scale(const ReportFigure& figure, double value);
std::string shown(const ReportFigure& figure, double value);  // "24.9 dB", "97 %"
std::string thresholds_text(const ReportFigure& figure);      // "good from 27 dB, borderline from 22 dB"

}  // namespace vitrine
