// Writes report.html of an output folder with the program vitrine-report (pipeline/report_page): for `vitrine report`, and at the
// end of every `vitrine run`, including failed ones.
#pragma once

#include <optional>
#include <string>

#include "core/foundation/base/file.h"

namespace vitrine {

fs::path html_report_path(const fs::path& project);
// Returns nothing on success, otherwise the reason. The signal that stopped the run does not stop it.
std::optional<std::string> write_html_report(const fs::path& project, bool only_if_changed);

}  // namespace vitrine
