#include "pipeline/given_inputs.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/config/photo_name_finder.h"
#include "core/config/text.h"

namespace vitrine {

namespace {

void check_marks(const std::string& path, const std::string& photos) {
  const YamlFile file = read_yaml(path);
  const PhotoNames names(photos);
  const YamlNode* marks = file.root.find("marks");
  if (names.empty() || marks == nullptr) return;  // ingest and masks have something to say about that
  ConfigErrors errors;
  for (const YamlNode& mark : marks->items) {
    const YamlNode* photo = mark.kind == YamlNode::Kind::Map ? mark.find("photo") : nullptr;
    if (photo == nullptr || photo->kind != YamlNode::Kind::Scalar || names.has_by_part(photo->text)) continue;
    const std::string near = names.nearest(photo->text);
    errors.add(
        file, photo->mark, photo->text.size(),
        fmt::format("there is no photo '{}'{}", photo->text, near.empty() ? "" : fmt::format(": did you mean '{}'?", near)));
  }
  errors.throw_if_any(fmt::format("marks name photos of {}", photos));
}

}  // namespace

PhotoNames::PhotoNames(const fs::path& photos) {
  std::error_code ec;
  for (fs::recursive_directory_iterator it(photos, ec), end; !ec && it != end; it.increment(ec))
    if (it->is_regular_file(ec)) files_.push_back(it->path().lexically_relative(photos));
  std::ranges::sort(files_);
}

bool PhotoNames::has(const std::string& name) const {
  return std::ranges::any_of(files_, [&](const fs::path& file) {
    const std::string extension = file.extension().string(), plain = fs::path(file).replace_extension().generic_string();
    const std::string twin = extension.empty() ? plain : plain + "_" + extension.substr(1);
    const std::string shown = extension == ".exr" || extension == ".EXR" ? ".png" : extension;
    return name == plain || name == twin || name == plain + shown || name == twin + shown;
  });
}

bool PhotoNames::has_by_part(const std::string& name) const {
  if (has(name)) return true;
  std::vector<std::string> names;
  for (const fs::path& file : files_) names.push_back(file.generic_string());
  const PhotoMatch meant = PhotoNameFinder(names).match(name);
  return meant.photo || !meant.could_be.empty();  // a stage says which ones it could be
}

std::string PhotoNames::nearest(const std::string& name) const {
  std::vector<std::string> names;
  for (const fs::path& file : files_) names.push_back(file.generic_string());
  return nearest_word(name, names);
}

void check_given_inputs(const Planner& planner, const Settings& settings) {
  std::set<std::string> names;  // given now, or read by chosen stages: the others may be gone since
  for (const StageNode& node : planner.graph().nodes)
    for (const NodeInput& input : node.inputs)
      if (!input.artifact && input.name != "photos" &&
          (planner.chosen(node) || settings.from_command.contains("input." + input.name)))
        names.insert(input.name);
  for (const std::string& name : names) {
    const Option& given = *settings.options.table.find("input." + name);
    const std::string value = given.text();
    std::error_code ec;
    if (value.empty() || value == "none") continue;
    if (!fs::exists(value, ec))
      throw Error(
          ErrorKind::Input, fmt::format("input '{}' does not exist", name),
          {.where = value, .why = fmt::format("{} names it", given.origin), .hint = "check the path", .code = "MISSING_INPUT"});
    if (name == "masks" && is_yaml_file(value)) check_marks(value, settings.text("input.photos"));
  }
}

std::string changed_settings(const Settings& before, const Settings& now) {
  std::string changes;
  const bool same_preset = before.text("preset") == now.text("preset");
  for (const Option& o : now.options.table.options) {
    const bool named = o.path == "preset" || o.path.starts_with("input.");
    if (o.path.starts_with("limits.") || (!named && !same_preset)) continue;  // another preset changes most of the others
    const Option* was = before.options.table.find(o.path);
    const std::string from = was == nullptr ? "" : was->text(), to = o.text();
    if (from == to) continue;
    changes += fmt::format("{}{} {} -> {}", changes.empty() ? "" : ", ", o.path.starts_with("input.") ? o.path.substr(6) : o.path,
                           from.empty() ? "none" : from, to.empty() ? "none" : to);
  }
  return changes;
}

}  // namespace vitrine
