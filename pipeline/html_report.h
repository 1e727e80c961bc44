// report.html of an output folder, written by the program vitrine-report (pipeline/report_page): `vitrine report`, and the end of
// every `vitrine run`, whether it went well or not.
#pragma once

#include <optional>
#include <string>

#include "core/base/file.h"

namespace vitrine {

fs::path html_report_path(const fs::path& project);
// Nothing when the page is there, else why not. Not stopped by the signal that stopped the run.
std::optional<std::string> write_html_report(const fs::path& project, bool only_if_changed);

}  // namespace vitrine
