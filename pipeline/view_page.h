// Writes view.html of an output folder with the program vitrine-view (stages/view): for `vitrine view`, and at the end of every
// `vitrine run` that trained a scene.
#pragma once

#include <optional>
#include <string>

#include "core/foundation/artifact/manifest.h"
#include "pipeline/tool.h"

namespace vitrine {

fs::path view_page_path(const fs::path& project);
// The relit picture made with the page (stages/view/relit_sample.h).
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
