// When a figure is good, borderline or bad: one table (thresholds.cpp), explained in README.md. A rating is an opinion about what
// to do next, not a measurement: the figures stand beside it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace vitrine {

// Unknown: measured on too little to say (figures.cpp); `rate` never gives it.
enum class Rating { Good, Borderline, Bad, Unknown };
std::string_view name(Rating rating);  // "good", "borderline", "bad", "unknown"

struct Rule {
  std::string_view id, label;
  std::string_view unit;      // behind the value; "%" shows a share of 1
  int decimals = 1;           // after the point, as shown
  double good = 0, okay = 0;  // at least (good > okay) or at most (good < okay) this is good, borderline; else bad
  std::string_view means;     // what the figure is
  std::string_view weak;      // what it says when it is not good
};

std::span<const Rule> rules();
const Rule& rule(std::string_view id);  // VITRINE_CHECK: it exists

Rating rate(const Rule& rule, double value);
// Where the value stands on a scale of three equal parts bad | borderline | good, in [0,1]; beyond the ends it stays just inside.
double place_on_scale(const Rule& rule, double value);
std::string shown(const Rule& rule, double value);  // "24.9 dB", "97 %"
std::string thresholds_text(const Rule& rule);      // "good from 27 dB, borderline from 22 dB"

}  // namespace vitrine
