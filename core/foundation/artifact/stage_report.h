// Report figures of a stage, with thresholds for good and fair, and unrated facts. Declared next to the config of the stage,
// printed by `vitrine-<stage> --describe`, shown in report.html.
//
// Paths address values of a JSON report: "points.kept"; "photos.*.known" is the values of all array items. Placeholders in braces
// insert values into a text (pipeline/report_page/facts.h): "{registered:0} of {photo_count:0}".
#pragma once

#include <string>
#include <vector>

namespace vitrine {

struct ReportFigure {
  std::string group, id, label;  // group: title of the group that shows the figure
  std::string unit;              // printed after the value; "%" prints a fraction as percent
  int decimals = 1;              // digits after the decimal point
  double good = 0, fair = 0;     // thresholds: minimum (good > fair: higher is better) or maximum (good < fair); beyond fair: bad
  std::string means, weak;       // description of the figure; text shown when it is not good
  std::string value;             // path of the value

  std::string fold = {}, where = {};       // reduction of several values; see folded()
  std::string minus = {}, over = {};       // paths; see difference(), share()
  std::string samples = {}, counted = {};  // see measured_on()
  double fewest = 0;
  bool shown_without = false;
  std::string note = {};  // text shown after the value

  bool higher_is_better() const { return good > fair; }
  // Reduces several values: "mean", "median" or "last" over the array items whose member `only` is true. "above_weakest_view":
  // difference between the value and the weakest held-out view; not shown with too few samples.
  ReportFigure& folded(std::string how, std::string only = {}) { return fold = how, where = only, *this; }
  ReportFigure& difference(std::string subtracted) { return minus = subtracted, *this; }
  ReportFigure& share(std::string whole) { return over = whole, *this; }  // no value if the whole is 0
  // With fewer than `least` samples the figure is not rated: "too few points (3)". If the path does not exist the figure is
  // rated. `shown`: a value missing for lack of samples is shown as unknown.
  ReportFigure& measured_on(std::string path, double least, std::string what, bool shown = false) {
    return samples = path, fewest = least, counted = what, shown_without = shown, *this;
  }
  ReportFigure& noted(std::string text) { return note = text, *this; }
};

struct ReportFact {
  std::string group;      // the fact is sorted into this group
  std::string text;       // omitted if a value is missing
  std::string once = {};  // among facts with the same `once`, only the first with all its values is shown
  std::string each = {};  // array; the values come from its first item that has all of them
};

struct StageReport {
  std::string file = {};  // report of the output folder that the paths refer to: "sfm/report.json"
  std::vector<ReportFigure> figures = {};
  std::vector<ReportFact> facts = {};
};

std::string stage_report_text(const StageReport& report);  // JSON
StageReport parse_stage_report(const std::string& json);   // empty if the text is not a report

}  // namespace vitrine
