// Evaluates the values and texts that stages declare for their reports (core/foundation/artifact/stage_report.h). A path component "*"
// matches all items of an array, or all members of an object. Placeholders in a text:
//   {mesh.faces:n}          a count, digits in groups of three; several values are summed  {psnr:1}  a number with one decimal
//   {a,b:1}                 the maximum; all must exist                                    {source}  a text
//   {views:view,views}      singular or plural                                             {verdict=thin,thick}  one of these
//   texts {layers.*.count:parts}  "40 000 front, 15 000 back": at least two members with their names
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/report_page/facts.h"

namespace vitrine {

// nullopt if a value is missing.
std::optional<std::string> fact_text(const std::string& text, const Facts& report);
// Numbers at a path, with the names of their members. `only`: restricts to items whose member of this name is true.
std::vector<std::pair<std::string, double>> numbers_at(const Facts& report, std::string_view path, std::string_view only = {});

}  // namespace vitrine
