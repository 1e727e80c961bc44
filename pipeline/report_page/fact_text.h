// Values and texts that stages declare of their reports (core/artifact/stage_report.h). A part "*" of a path stands for all items
// of an array, or all members of an object. Places in a text:
//   {mesh.faces:n}          a count, in groups of three digits; the sum of several     {psnr:1}  a number with one decimal
//   {a,b:1}                 the larger one, all must be there                          {source}  a text
//   {views:view,views}      the first word for one, else the second                    {verdict=thin,thick}  one of these texts
//   {layers.*.count:parts}  "40 000 front, 15 000 back": at least two members with their names
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/report_page/facts.h"

namespace vitrine {

// nullopt where a value is missing.
std::optional<std::string> fact_text(const std::string& text, const Facts& report);
// Numbers at a path, with the names of members. `only`: of those items whose member of this name is true.
std::vector<std::pair<std::string, double>> numbers_at(const Facts& report, std::string_view path, std::string_view only = {});

}  // namespace vitrine
