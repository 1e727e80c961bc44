#include "core/scene/camera/view_split.h"

#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"

namespace vitrine {

ViewSplit read_view_split(const std::filesystem::path& path, const std::vector<View>& views) {
  const auto fail = [&](const std::string& why) -> Error {
    return Error(ErrorKind::Input, "the list of training and held-out views is unusable",
                 {.where = path.string(), .why = why, .hint = "run the optimize stage again", .code = "BAD_VIEW_SPLIT"});
  };
  std::map<std::string, size_t> index;
  for (size_t i = 0; i < views.size(); ++i) index.emplace(views[i].name, i);
  const std::string text = read_file(path);
  ViewSplit split;
  try {
    const auto json = nlohmann::json::parse(text);
    split.holdout_every = json.at("holdout_every").get<int>();
    split.max_side = json.at("max_side").get<int>();
    split.object_alone = json.value("object_alone", false);
    for (const auto& [key, list] : {std::pair{"train", &split.train}, {"heldout", &split.heldout}})
      for (const auto& item : json.at(key)) {
        const auto it = index.find(item.get<std::string>());
        if (it == index.end()) throw fail("no view is called " + item.get<std::string>());
        list->push_back(it->second);
      }
  } catch (const nlohmann::json::exception& e) {
    throw fail(cause_of(e));
  }
  if (split.max_side < 0) throw fail("max_side is negative");
  if (split.train.empty() && split.heldout.empty()) throw fail("it names no views");
  return split;
}

std::vector<View> at_trained_size(const std::vector<View>& views, const std::vector<size_t>& indices, const ViewSplit& split) {
  std::vector<View> out;
  for (size_t i : indices) {
    out.push_back(views[i]);
    out.back().intrinsics = out.back().intrinsics.limited_to(split.max_side);
  }
  return out;
}

}  // namespace vitrine
