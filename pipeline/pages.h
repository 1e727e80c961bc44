// The HTML pages of an output folder: report.html by the program vitrine-report (pipeline/report_page), at the end of every
// `vitrine run`, including failed ones, and by `vitrine report`; view.html by the program vitrine-view (stages/view), at the end
// of every `vitrine run` that trained a scene, and by `vitrine view`.
#pragma once

#include <optional>
#include <string>

#include "core/foundation/artifact/manifest.h"
#include "core/foundation/base/file.h"
#include "pipeline/tool.h"

namespace vitrine {

fs::path html_report_path(const fs::path& project);
// Returns nothing on success, otherwise the reason. The signal that stopped the run does not stop it.
std::optional<std::string> write_html_report(const fs::path& project, bool only_if_changed);

fs::path view_page_path(const fs::path& project);
// The relit picture made with the page (stages/view/view.cpp).
fs::path relit_sample_path(const fs::path& project);
// Inputs of the page.
ToolInputs view_inputs(const fs::path& edited = {});
// Links the page into the project folder and records it as current.
void keep_view_page(const fs::path& project, const ToolResult& page);

enum class ViewPage : unsigned char { Written, NoScene, Failed };
struct ViewPageOutcome {
  ViewPage what = ViewPage::NoScene;
  std::string why = {};  // reason of Failed
};
// For the end of a run: prints nothing, throws nothing, and ignores the signal that stopped the run. The project must be locked.
ViewPageOutcome write_view_page(const fs::path& project);

}  // namespace vitrine
