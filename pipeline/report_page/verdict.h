// Overall verdict: success, weak spots, next steps. Two sentences and a command.
#pragma once

#include <string>
#include <vector>

#include "pipeline/report_page/figures.h"

namespace vitrine {

enum class Mood { Good, Borderline, Bad, Unfinished };

struct Advice {
  std::string text;     // advice
  std::string command;  // ready to paste; may be empty
};

struct WeakSpot {
  std::string text;    // "Pictures from new places are soft."
  std::string figure;  // "New views, PSNR: 24.9 dB"; empty for the causes of a failure
};

struct Verdict {
  Mood mood = Mood::Good;
  std::string word;            // "It worked"
  std::string sentence;        // quality of the result
  std::vector<WeakSpot> weak;  // most important first, at most kMostWeak
  std::vector<Advice> next;    // in order of priority
};

inline constexpr size_t kMostWeak = 3;

// `project`: the output folder as typed in a command.
Verdict verdict_of(const RunOutcome& outcome, const Figures& figures, const std::string& project);

}  // namespace vitrine
