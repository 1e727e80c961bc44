// The figures of a run that its stages declare (core/artifact/stage_report.h), read from the reports in its folder and rated.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/report_page/outcome.h"
#include "pipeline/report_page/thresholds.h"

namespace vitrine {

struct Figure {
  ReportFigure rule;
  double value = 0;  // NaN: there is none
  Rating rating = Rating::Good;
  std::string note;     // evidence beside the value: "36 of 36", the photo's name
  std::string unknown;  // why it is not rated: "too few points (0)"
};

struct FigureGroup {
  std::string title;
  std::vector<Figure> figures;
};

// How a photo fared in the search for camera poses.
struct PhotoPose {
  std::string name, reason;  // reason: why it has no pose
  bool registered = false;
  double features = 0, matches = 0, observations = 0;
};

struct PhotoScore {
  std::string name;
  bool heldout = false;
  double psnr = 0;
  std::optional<double> ssim;
  std::map<std::string, double> regions;  // psnr of the region's pixels
};

struct Figures {
  std::vector<FigureGroup> groups;  // without empty ones
  std::vector<PhotoPose> photos;    // in name order
  std::vector<PhotoScore> views;
  std::vector<std::string> facts;  // sentences without a rating: what was made, and of what size

  const Figure* find(std::string_view id) const;
};

// What the stages declare of their reports, from the descriptions beside this program; empty where they cannot be read.
struct DeclaredReport {
  std::string stage, doing;
  StageReport report;
};
const std::vector<DeclaredReport>& declared_reports();
// A figure that a stage declares, and where; nullptr: none does.
const ReportFigure* declared_figure(std::string_view id);

Figures gather_figures(const fs::path& project, const RunOutcome& outcome);

}  // namespace vitrine
