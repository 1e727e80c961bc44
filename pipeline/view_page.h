// view.html of an output folder, made by the program vitrine-view (stages/view): `vitrine view`, and the end of every `vitrine
// run` that trained a scene.
#pragma once

#include <optional>
#include <string>

#include "core/artifact/manifest.h"
#include "pipeline/tool.h"

namespace vitrine {

fs::path view_page_path(const fs::path& project);
// A relit picture that is made with it (stages/view/relit_sample.h).
fs::path relit_sample_path(const fs::path& project);
// What the page is made from.
ToolInputs view_inputs(const fs::path& edited = {});
// Where a page that was made from the project lies from now on: in its folder, and in its record of what is current.
void keep_view_page(const fs::path& project, const ToolResult& page);

enum class ViewPage : unsigned char { Written, NoScene, Failed };
struct ViewPageOutcome {
  ViewPage what = ViewPage::NoScene;
  std::string why = {};  // of Failed
};
// For the end of a run: nothing is printed, nothing is thrown, and the signal that stopped a run does not stop it. The project
// must be locked.
ViewPageOutcome write_view_page(const fs::path& project);

}  // namespace vitrine
