#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/scene/camera/view_set.h"
#include "pipeline/python/bindings.h"

namespace vitrine {

FinishedRun::FinishedRun(const fs::path& project, bool edited) : project_(fs::absolute(project).lexically_normal()) {
  std::error_code ec;
  if (!fs::is_regular_file(project_ / "vitrine.yaml", ec))
    throw Error(ErrorKind::Input, "this is no output folder of vitrine",
                {.where = project_.string(),
                 .why = "it has no vitrine.yaml",
                 .hint = "vitrine run PHOTOS -o DIR makes one",
                 .code = "NO_PROJECT"});
  if (edited) {
    const auto entry = artifact("edit");
    if (!entry)
      throw Error(ErrorKind::Input, "this scene has no edits",
                  {.where = project_.string(), .hint = "vitrine edit PROJECT edits.yaml", .code = "NO_EDITS"});
    edited_ = *entry / "edited";
  }
  required("sfm", "there is no trained scene yet");
  required("optimize", "there is no trained scene yet");
}

std::optional<fs::path> FinishedRun::artifact(const std::string& stage) const {
  const bool replaced = stage == "optimize" || stage == "mesh" || stage == "decompose";
  if (!edited_.empty() && replaced) return edited_;
  if (!edited_.empty() && stage == "refine") return std::nullopt;  // the edited surfels include the refinement
  const auto key = current_key(project_, stage);
  return key ? std::optional(store_of(project_) / stage / *key) : std::nullopt;
}

fs::path FinishedRun::required(const std::string& stage, const std::string& missing) const {
  if (const auto found = artifact(stage)) return *found;
  throw Error(ErrorKind::Input, missing,
              {.where = project_.string(),
               .why = fmt::format("the stage '{}' has not been computed", stage),
               .hint = "vitrine run " + project_.string(),
               .code = "NO_SCENE"});
}

TrainedScene FinishedRun::trained() const { return read_trained_scene(*artifact("optimize"), artifact("refine")); }

std::vector<View> FinishedRun::views(ViewChoice which) const {
  return picture_views({.which = which, .sfm = *artifact("sfm"), .optimize = *artifact("optimize")});
}

std::vector<std::string> FinishedRun::heldout() const {
  const std::vector<View> all = load_view_set(*artifact("sfm")).views;
  std::vector<std::string> names;
  for (const size_t i : read_view_split(*artifact("optimize") / "optimize" / "views.json", all).heldout)
    names.push_back(all[i].name);
  return names;
}

RelitScene FinishedRun::relit() const {
  const std::string missing = "this scene cannot be relit yet";
  return read_relit_scene({.optimize = *artifact("optimize"),
                           .refine = artifact("refine"),
                           .mesh = required("mesh", missing),
                           .decompose = required("decompose", missing)});
}

}  // namespace vitrine
