#include "stages/mesh/training_views.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/json.h"

namespace vitrine {

std::vector<View> training_views(const ViewSet& set, const fs::path& optimize_folder, int max_side) {
  const fs::path path = optimize_folder / "optimize" / "views.json";
  const auto fail = [&](std::string why) -> Error {
    return Error(ErrorKind::Input, "cannot tell which views were trained on",
                 {.where = path.string(), .why = std::move(why), .hint = "run the optimize stage again", .code = "BAD_VIEWS"});
  };
  const std::string text = read_file(path);
  std::vector<std::string> names;
  try {
    const nlohmann::json document = nlohmann::json::parse(text);
    names = document.at("train").get<std::vector<std::string>>();
    if (max_side <= 0) max_side = document.at("max_side").get<int>();
  } catch (const nlohmann::json::exception& e) {
    throw fail(cause_of(e));
  }
  if (names.empty()) throw fail("it names no training view");
  std::vector<View> views;
  for (const std::string& name : names) {
    const auto found = std::find_if(set.views.begin(), set.views.end(), [&](const View& v) { return v.name == name; });
    if (found == set.views.end()) throw fail(fmt::format("view '{}' is not in the sfm artifact", name));
    views.push_back(*found);
    views.back().intrinsics = found->intrinsics.limited_to(max_side);
  }
  return views;
}

}  // namespace vitrine
