// Report figures of a stage, with the limits of good and fair, and facts without a rating. Declared beside the config of the
// stage, printed by `vitrine-<stage> --describe`, shown by report.html.
//
// Paths lead into a JSON report: "points.kept"; "photos.*.known" are the values of all items of an array. A text takes values
// from it in braces (pipeline/report_page/fact_text.h): "{registered:0} of {photo_count:0}".
#pragma once

#include <string>
#include <vector>

namespace vitrine {

struct ReportFigure {
  std::string group, id, label;  // group: title of the group in which it is shown
  std::string unit;              // behind the value; "%" shows a share of 1
  int decimals = 1;              // after the point, as shown
  double good = 0, fair = 0;     // at least (good > fair: higher is better) or at most (good < fair) this is good, fair; else bad
  std::string means, weak;       // what the figure is; what it says when it is not good
  std::string value;             // path

  std::string fold = {}, where = {};       // of several values; see folded()
  std::string minus = {}, over = {};       // paths; see difference(), share()
  std::string samples = {}, counted = {};  // see measured_on()
  double fewest = 0;
  bool shown_without = false;
  std::string note = {};  // text beside the value

  bool higher_is_better() const { return good > fair; }
  // "mean", "median" or "last" of several values: of the items of the array whose member `only` is true. "above_weakest_view":
  // how far the weakest held-out view lies below the value; not shown of too few samples.
  ReportFigure& folded(std::string how, std::string only = {}) { return fold = how, where = only, *this; }
  ReportFigure& difference(std::string subtracted) { return minus = subtracted, *this; }
  ReportFigure& share(std::string whole) { return over = whole, *this; }  // none where the whole is 0
  // Of fewer than `least` samples the figure says nothing about good or bad: "too few points (3)". Where the path leads nowhere
  // the figure is believed. `shown`: a value that is missing because there are no samples is shown as unknown.
  ReportFigure& measured_on(std::string path, double least, std::string what, bool shown = false) {
    return samples = path, fewest = least, counted = what, shown_without = shown, *this;
  }
  ReportFigure& noted(std::string text) { return note = text, *this; }
};

struct ReportFact {
  std::string group;      // its place among the others is that of the group
  std::string text;       // left out where a value is missing
  std::string once = {};  // of all facts with the same word the first that has its values is shown
  std::string each = {};  // array whose first item that has all values gives them
};

struct StageReport {
  std::string file = {};  // of the output folder, which the paths lead into: "sfm/report.json"
  std::vector<ReportFigure> figures = {};
  std::vector<ReportFact> facts = {};
};

std::string stage_report_text(const StageReport& report);  // JSON
StageReport parse_stage_report(const std::string& json);   // empty where it is none

}  // namespace vitrine
