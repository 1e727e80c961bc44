// Report figures declared by the stages (core/foundation/artifact/stage_report.h): values read from the reports of a run, and
// ratings by the declared thresholds (README.md). A rating advises what to improve; the measured values are shown with it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/artifact/stage_report.h"
#include "pipeline/report_page/outcome.h"

namespace vitrine {

// Unknown: too few samples (figure_of); never returned by `rate`.
enum class Rating { Good, Borderline, Bad, Unknown };
std::string_view name(Rating rating);  // "good", "borderline", "bad", "unknown"

Rating rate(const ReportFigure& figure, double value);
// Position of the value on a scale of three equal parts bad | borderline | good, in [0,1]; clamped slightly inside the ends.
double place_on_scale(const ReportFigure& figure, double value);
std::string shown(const ReportFigure& figure, double value);  // "24.9 dB", "97 %"
std::string thresholds_text(const ReportFigure& figure);      // "good from 27 dB, borderline from 22 dB"

struct Figure {
  ReportFigure rule;
  double value = 0;  // NaN: no value
  Rating rating = Rating::Good;
  std::string note;     // supporting text: "36 of 36", the photo's name
  std::string unknown;  // reason for no rating: "too few points (0)"
};

struct FigureGroup {
  std::string title;
  std::vector<Figure> figures;
};

// Result of a photo in pose estimation.
struct PhotoPose {
  std::string name, reason;  // reason: cause of a missing pose
  bool registered = false;
  double features = 0, matches = 0, observations = 0;
};

struct PhotoScore {
  std::string name;
  bool heldout = false;
  double psnr = 0;
  std::optional<double> ssim;
  std::map<std::string, double> regions;  // PSNR of the pixels of each region
};

struct Figures {
  std::vector<FigureGroup> groups;  // without empty groups
  std::vector<PhotoPose> photos;    // sorted by name
  std::vector<PhotoScore> views;
  std::vector<std::string> facts;  // unrated sentences: outputs and their sizes

  const Figure* find(std::string_view id) const;
};

// Declarations of the stages, from the descriptions next to this program; empty if they cannot be read.
struct DeclaredReport {
  std::string stage, doing;
  StageReport report;
};
const std::vector<DeclaredReport>& declared_reports();
// Declaration of a figure; nullptr if no stage declares it.
const ReportFigure* declared_figure(std::string_view id);

Figures gather_figures(const fs::path& project, const RunOutcome& outcome);

// Overall verdict: success, weak spots, next steps. Two sentences and a command.

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
