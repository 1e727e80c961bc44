#include "pipeline/given_inputs.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/config/json_file.h"
#include "core/foundation/config/photo_name_finder.h"
#include "core/foundation/config/text.h"
#include "core/intake/depth/depth_files.h"
#include "core/intake/masks/marks_check.h"
#include "core/intake/masks/photo_masks.h"
#include "core/intake/photos/linear_photo.h"

namespace vitrine {

namespace {

// Checks a folder or transforms.json of masks with the code of the sfm and masks stages.
void check_masks(const fs::path& masks, const Settings& settings) {
  std::vector<std::string> photos = PhotoNames(settings.text("input.photos")).all();
  if (photos.empty()) return;  // ingest reports the problem
  const auto option = [&](const std::string& path, const std::string& otherwise) {
    const Option* o = settings.options.table.find(path);
    return o == nullptr ? otherwise : o->text();
  };
  std::vector<MaskClass> used;
  for (MaskClass kind : kMaskClasses) {
    const std::string source = option(fmt::format("masks.{}.source", name(kind)), "auto");
    const bool of_features = option(fmt::format("sfm.masks.{}", name(kind)), "off") != "off" &&
                             !(kind == MaskClass::Object && option("sfm.turntable", "auto") == "no");
    if (source == "auto" || source == "files" || of_features) used.push_back(kind);
  }
  check_mask_names(masks, mask_class(option("masks.flat", "object")).value_or(MaskClass::Object), photos, used);
}

// Checks the names of depth maps, and one of them, with the code of the normals stage.
void check_depth(const fs::path& depth, const Settings& settings) {
  const std::vector<std::string> photos = PhotoNames(settings.text("input.photos")).all();
  if (!photos.empty()) check_depth_names(depth, photos);
}

// Rejects a file that is not an object table before any stage runs; the objects stage validates its entries.
void check_objects(const fs::path& given) {
  std::error_code ec;
  const fs::path file = fs::is_directory(given, ec) ? given / "objects.json" : given;
  read_json_file(file, "table of objects", [](const nlohmann::json& j) {
    if (!JsonAt(j).at("objects").value().is_array()) throw JsonMistake("/objects", "objects: expected a list");
  });
}

}  // namespace

PhotoNames::PhotoNames(const fs::path& photos) {
  try {
    if (!gives_film_frames(photos)) files_ = find_photos(photos).photos;  // names of frames are known after ingest
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
  }
}

std::vector<std::string> PhotoNames::all() const {
  std::vector<std::string> names;
  for (const PhotoFile& file : files_) names.push_back(file.name);
  return names;
}

std::vector<std::string> PhotoNames::sources() const {
  std::vector<std::string> names;
  for (const PhotoFile& file : files_) names.push_back(file.source);
  return names;
}

std::optional<size_t> PhotoNames::find(const std::string& name) const {
  const auto same = std::ranges::find_if(files_, [&](const PhotoFile& file) { return name == file.name || name == file.stem; });
  return same == files_.end() ? std::nullopt : std::optional(size_t(same - files_.begin()));
}

std::optional<size_t> PhotoNames::find_by_part(const YamlNode& name, YamlReader& in) const {
  if (const auto same = find(name.text)) return same;
  const std::vector<std::string> names = sources();
  const PhotoNameFinder finder(names);
  const PhotoMatch meant = finder.match(name.text);
  if (meant.photo) return meant.photo;
  const std::string near = nearest(name.text);
  if (!meant.could_be.empty())
    in.complain(name, fmt::format("'{}' may be {}: write all of its name", name.text, listed(finder, meant.could_be)));
  else
    in.complain(
        name, fmt::format("there is no photo '{}'{}", name.text, near.empty() ? "" : fmt::format(": did you mean '{}'?", near)));
  return std::nullopt;
}

std::optional<PhotoPixels> PhotoNames::pixels(size_t photo) const {
  try {
    const PhotoSize size = upright_size(read_photo_head(files_[photo].path, files_[photo].balance));
    if (size.width > 0) return PhotoPixels{size.width, size.height};
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;  // ingest reports an unreadable photo
  }
  return std::nullopt;
}

std::string PhotoNames::nearest(const std::string& name) const { return nearest_word(name, sources()); }

void check_marks(const fs::path& marks, const fs::path& photos) {
  const PhotoNames files(photos);
  const std::vector<std::string> names = files.all();
  check_marks(marks, {.names = names,
                      .find = [&](const YamlNode& name, YamlReader& in) { return files.find_by_part(name, in); },
                      .size = [&](size_t photo) { return files.pixels(photo); }});
}

void check_inputs_apart(const fs::path& project, const Graph& graph, const Settings& settings) {
  std::set<std::string> results{"images", "linear", "sparse", "eval", "edited", ".cache"}, names;
  for (const StageNode& node : graph.nodes) {
    results.insert(node.name);
    for (const NodeInput& input : node.inputs)
      if (!input.artifact) names.insert(input.name);
  }
  for (const std::string& name : names) {
    const std::string path = settings.text("input." + name);
    std::error_code ec;
    if (path.empty() || path == "none" || !fs::is_directory(path, ec)) continue;
    if (lies_in(project, path))
      throw Error(ErrorKind::Usage, fmt::format("the output folder lies inside the folder of {}", name),
                  {.where = project.string(),
                   .why = name == "photos" ? std::string() : fmt::format("{} = {}", name, path),
                   .hint = "choose another one with -o",
                   .code = "USAGE"});
    if (!lies_in(path, project)) continue;
    const fs::path below = fs::weakly_canonical(path, ec).lexically_relative(fs::weakly_canonical(project, ec));
    if (!below.empty() && results.contains(below.begin()->string()))
      throw Error(
          ErrorKind::Usage, fmt::format("the folder of {} lies where results are written", name),
          {.where = path,
           .why = fmt::format("{} in the output folder {} is replaced by results", below.begin()->string(), project.string()),
           .hint = "choose another output folder with -o, or move what is given out of it",
           .code = "USAGE"});
  }
}

void check_given_inputs(const Planner& planner, const Settings& settings) {
  std::set<std::string> names;  // inputs given now, or read by chosen stages; others may have been deleted
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
    if (name == "objects") check_objects(value);
    if (name == "depth") check_depth(value, settings);
    if (name != "masks") continue;
    if (is_yaml_file(value))
      check_marks(value, settings.text("input.photos"));
    else
      check_masks(value, settings);
  }
}

std::string changed_settings(const Settings& before, const Settings& now) {
  std::string changes;
  const bool same_preset = before.text("preset") == now.text("preset");
  for (const Option& o : now.options.table.options) {
    const bool named = o.path == "preset" || o.path.starts_with("input.");
    if (o.path.starts_with("limits.") || (!named && !same_preset)) continue;  // another preset changes most other options
    const Option* was = before.options.table.find(o.path);
    const std::string from = was == nullptr ? "" : was->text(), to = o.text();
    if (from == to) continue;
    changes += fmt::format("{}{} {} -> {}", changes.empty() ? "" : ", ", o.path.starts_with("input.") ? o.path.substr(6) : o.path,
                           from.empty() ? "none" : from, to.empty() ? "none" : to);
  }
  return changes;
}

}  // namespace vitrine
