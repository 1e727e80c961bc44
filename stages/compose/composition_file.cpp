#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/config/chart.h"
#include "core/foundation/config/yaml.h"
#include "core/render/edit/selection_file.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/scale_bar_length.h"
#include "core/scene/camera/view_set.h"
#include "stages/compose/compose.h"

namespace vitrine {

namespace {

constexpr double kLargestScale = 1e6;
constexpr const char* kHint = "stages/compose/README.md shows the format";

fs::path project_path(const fs::path& file, const std::string& word) {
  return (fs::absolute(file).parent_path() / word).lexically_normal();
}

std::optional<fs::path> artifact(const fs::path& project, const char* stage) {
  const auto key = current_key(project, stage);
  return key ? std::optional(store_of(project) / stage / *key) : std::nullopt;
}

// Metres of a scene unit by the options of the stage export, which `vitrine run --scale-bar` sets.
std::optional<double> exported_unit(const fs::path& project, const CompositionPart& part) {
  const auto key = current_key(project, "export");
  const auto manifest = key ? ArtifactStore(store_of(project)).find("export", *key) : std::nullopt;
  if (!manifest) return std::nullopt;
  const auto value = [&](std::string_view path) {
    const auto option = std::ranges::find(manifest->options, path, &OptionEcho::path);
    return option == manifest->options.end() ? std::string() : option->value;
  };
  if (const std::string bar = value("scale_bar"); !bar.empty())
    return scale_bar_length(parse_scale_bar(bar), part.views, read_passes(part.sfm)).metres_per_unit;
  if (const std::string text = value("scale_points"); !text.empty()) {
    const ScalePoints points = parse_scale_points(text);
    return points.length_m / points.scene_units();
  }
  double metres = 0;
  const std::string scale = value("scale");
  std::from_chars(scale.data(), scale.data() + scale.size(), metres);
  return metres > 0 ? std::optional(metres) : std::nullopt;
}

class Reader {
 public:
  explicit Reader(const fs::path& file) : file_(file), in_(read_yaml(file.string())) {}

  std::vector<CompositionPart> parts() {
    const YamlNode& root = in_.root();
    in_.only_keys(root, {"parts"});
    const YamlNode* list = root.find("parts");
    if (list == nullptr || list->kind != YamlNode::Kind::List || list->items.empty())
      in_.complain(list != nullptr ? *list : root, "parts must be a list of projects");
    else
      for (const YamlNode& node : list->items) read(node);
    in_.finish(kHint);
    for (size_t i = 0; i < parts_.size(); ++i) complete(i);
    in_.finish(kHint);
    return std::move(parts_);
  }

 private:
  struct Written {
    fs::path folder;
    const YamlNode *project, *name, *select, *place;
    bool edited;
  };

  // What needs no artifact.
  void read(const YamlNode& node) {
    in_.only_keys(node, {"project", "name", "select", "edited", "place"});
    if (node.kind != YamlNode::Kind::Map) return;
    const YamlNode *project = node.find("project"), *name = node.find("name"), *edited = node.find("edited"),
                   *place = node.find("place");
    if (project == nullptr || project->text.empty())
      return in_.complain(node, "a part needs 'project': an output folder of vitrine run");
    CompositionPart part;
    part.where = fmt::format("{}:{}:{}", in_.name(), project->mark.line, project->mark.column);
    part.project = project->text;
    if (edited != nullptr && edited->text != "true") in_.complain(*edited, "it can only be 'edited: true'");
    if (name != nullptr && name->text.empty()) in_.complain(*name, "a name is a word or a sentence");
    if (place != nullptr) take_place(*place, part);
    if (place != nullptr && parts_.empty())
      in_.complain(*place, "the first part is the host: its frame is that of the composition");
    written_.push_back({project_path(file_, project->text), project, name, node.find("select"), place, edited != nullptr});
    parts_.push_back(std::move(part));
  }

  // Artifacts, selection and unit.
  void complete(size_t index) {
    CompositionPart& part = parts_[index];
    const Written& w = written_[index];
    take_artifacts(w.folder, w.edited, part);
    part.name = w.folder.has_filename() ? w.folder.filename().string() : w.folder.parent_path().filename().string();
    part.wanted = "all";
    if (w.select != nullptr) {
      std::string words;
      const Selector chosen = read_selector(in_, *w.select, part.views, words);
      if (words != "all") part.select = chosen, part.wanted = words;
      if (chosen.object) part.name = *chosen.object;
    }
    if (w.name != nullptr) part.name = w.name->text;
    if (index > 0 && w.place != nullptr && w.place->find("same_poses") != nullptr)
      part.place = place_by_poses(index);
    else if (index > 0 && (w.place == nullptr || w.place->find("scale") == nullptr))
      part.place.scale = common_scale(index);
    for (size_t i = 0; i < index; ++i)
      if (parts_[i].folders.optimize == part.folders.optimize && parts_[i].wanted == part.wanted &&
          same_place(parts_[i].place, part.place))
        in_.complain(*w.project, "this part is there already, in the same place");
  }

  static bool same_place(const Similarity& a, const Similarity& b) {
    return a.scale == b.scale && a.rotation == b.rotation && a.translation == b.translation;
  }

  static void take_artifacts(const fs::path& project, bool edited, CompositionPart& part) {
    std::error_code ec;
    if (!fs::is_regular_file(project / "vitrine.yaml", ec))
      throw Error(ErrorKind::Input, fmt::format("'{}' is no output folder of vitrine", part.project),
                  {.where = part.where,
                   .why = fmt::format("{} has no vitrine.yaml", project.string()),
                   .hint = "give the output folder of vitrine run, from the folder of the list",
                   .code = "NO_PROJECT"});
    const auto needed = [&](const char* stage) {
      if (const auto found = artifact(project, stage)) return *found;
      throw Error(ErrorKind::Input, fmt::format("'{}' has no finished scene", part.project),
                  {.where = part.where,
                   .why = fmt::format("the stage '{}' has not been computed", stage),
                   .hint = "vitrine run " + part.project,
                   .code = "NO_SCENE"});
    };
    part.sfm = needed("sfm");
    part.folders = {.optimize = needed("optimize"),
                    .mesh = needed("mesh"),
                    .refine = artifact(project, "refine"),
                    .decompose = artifact(project, "decompose")};
    part.masks = artifact(project, "masks"), part.objects = artifact(project, "objects");
    part.views = load_view_set(part.sfm, part.folders.optimize).views;
    if (!edited) return;
    const auto edits = artifact(project, "edit");
    if (!edits)
      throw Error(ErrorKind::Input, fmt::format("'{}' has no edits", part.project),
                  {.where = part.where, .hint = "vitrine edit PROJECT edits.yaml", .code = "NO_EDITS"});
    const fs::path changed = *edits / "edited";
    part.folders = {.optimize = changed,
                    .mesh = changed,
                    .refine = std::nullopt,
                    .decompose = part.folders.decompose ? std::optional(changed) : std::nullopt};
  }

  void take_place(const YamlNode& node, CompositionPart& part) {
    in_.only_keys(node, {"same_poses", "translate", "rotate", "scale"});
    if (node.kind != YamlNode::Kind::Map) return;
    if (const YamlNode* same = node.find("same_poses"))
      if (same->text != "true" || node.entries.size() > 1) in_.complain(*same, "it can only be 'place: {same_poses: true}'");
    if (const YamlNode* by = node.find("translate"))
      if (const auto t = in_.numbers(*by, 3, "[x, y, z] in units of the first part"))
        part.place.translation = {(*t)[0], (*t)[1], (*t)[2]};
    if (const YamlNode* turn = node.find("rotate")) take_rotation(*turn, part);
    if (const YamlNode* scale = node.find("scale")) {
      const auto s = in_.number(*scale);
      if (s && !(*s >= 1 / kLargestScale && *s <= kLargestScale))
        in_.complain(*scale, fmt::format("a scale lies between {} and {}, got {}", 1 / kLargestScale, kLargestScale, *s));
      else if (s)
        part.place.scale = *s;
    }
  }

  void take_rotation(const YamlNode& node, CompositionPart& part) {
    in_.only_keys(node, {"axis", "angle"});
    if (node.kind != YamlNode::Kind::Map) return;
    const YamlNode *along = node.find("axis"), *by = node.find("angle");
    if (by == nullptr) return in_.complain(node, "a rotation needs 'angle', in degrees");
    const auto degrees = in_.number(*by);
    Vec3d axis{0, 0, 1};
    if (along != nullptr) {
      const auto a = in_.numbers(*along, 3, "[x, y, z], the axis of the rotation");
      if (!a) return;
      axis = {(*a)[0], (*a)[1], (*a)[2]};
      if (!(length(axis) > 0)) return in_.complain(*along, "an axis has a length");
    }
    if (!degrees || *degrees == 0) return;
    const double half = *degrees * std::numbers::pi / 360;
    axis = std::sin(half) * normalized(axis);
    part.place.rotation = rotation_matrix(Quatd{std::cos(half), axis.x, axis.y, axis.z});
  }

  std::optional<double> metres(size_t index) const {
    const auto known = read_scene_info(parts_[index].sfm / "scene.json").metres_per_unit();
    return known ? known : exported_unit(written_[index].folder, parts_[index]);
  }

  // Digest of the poses that the project was given; empty: none.
  std::string given_poses(size_t index) const {
    const fs::path& project = written_[index].folder;
    const auto manifest = ArtifactStore(store_of(project)).find("sfm", *current_key(project, "sfm"));
    const auto term = manifest ? manifest->terms.find("input.poses") : KeyTerms::const_iterator();
    return manifest && term != manifest->terms.end() ? term->second : std::string();
  }

  // Each project has normalised the frame of its poses by its own cameras.
  Similarity place_by_poses(size_t index) const {
    const CompositionPart &host = parts_.front(), &part = parts_[index];
    const std::string of_host = given_poses(0), of_part = given_poses(index);
    if (of_host.empty() || of_part.empty() || of_host != of_part)
      throw Error(ErrorKind::Input, fmt::format("'{}' and '{}' were not given the same poses", host.name, part.name),
                  {.where = part.where,
                   .why = of_host.empty() || of_part.empty()
                              ? fmt::format("'{}' was computed without --poses", of_host.empty() ? host.name : part.name)
                              : "their poses differ, and so may their frames",
                   .hint = "vitrine run PHOTOS -o PROJECT --poses FILE, for both with one file that has the poses of all photos",
                   .code = "NOT_SAME_POSES"});
    const Similarity scene = read_scene_info(host.sfm / "scene.json").scene_from_colmap,
                     other = inverse(read_scene_info(part.sfm / "scene.json").scene_from_colmap);
    return {scene.scale * other.scale, scene.rotation * other.rotation, scene * other.translation};
  }

  // Units of the host per unit of the part.
  double common_scale(size_t index) const {
    const CompositionPart &host = parts_.front(), &part = parts_[index];
    if (part.sfm == host.sfm) return 1;
    const auto of_host = metres(0), of_part = metres(index);
    if (of_host && of_part) return *of_part / *of_host;
    throw Error(
        ErrorKind::Input, fmt::format("'{}' and '{}' have no common unit", host.name, part.name),
        {.where = part.where,
         .why = fmt::format("the length of a unit of '{}' is not known", of_host ? part.name : host.name),
         .hint = "give place: {scale: S}, units of the first part in one of this; or measure both scenes: vitrine run PROJECT "
                 "--scale-bar MARKS",
         .code = "NO_COMMON_UNIT"});
  }

  fs::path file_;
  YamlReader in_;
  std::vector<CompositionPart> parts_;
  std::vector<Written> written_;  // [parts_]
};

}  // namespace

std::vector<CompositionPart> read_composition(const fs::path& file) { return Reader(file).parts(); }

std::vector<fs::path> composition_files(const fs::path& file) {
  std::vector<fs::path> out;
  const YamlFile yaml = read_yaml(file.string());
  const YamlNode* list = yaml.root.kind == YamlNode::Kind::Map ? yaml.root.find("parts") : nullptr;
  if (list == nullptr) return out;
  for (const YamlNode& part : list->items) {
    const YamlNode* project = part.kind == YamlNode::Kind::Map ? part.find("project") : nullptr;
    if (project == nullptr || project->text.empty()) continue;
    for (const char* stage : {"sfm", "optimize", "mesh", "refine", "decompose", "masks", "objects", "edit", "export"}) {
      const auto folder = artifact(project_path(file, project->text), stage);
      std::error_code ec;
      if (folder && fs::exists(*folder / kManifestName, ec)) out.push_back(*folder / kManifestName);
    }
  }
  return out;
}

}  // namespace vitrine
