#include "stages/compose/compose.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/render/edit/joined_scene.h"
#include "core/render/edit/placed_scene.h"
#include "core/render/raster/renderer.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

bool selects(const std::vector<uint8_t>& flags) { return std::ranges::count(flags, 1) > 0; }

// k_s > 1/2: what the surfel shows is in the reflection layer.
bool reflects(const SplatLayer& diffuse) {
  const std::span<const float> weights = diffuse.values(Attribute::SpecularWeight);
  return std::ranges::any_of(weights, [](float raw) { return raw > 0; });
}

// The selected part of its scene, in the frame of the host. There is one sky, that of the host.
ScenePart scene_part(const CompositionPart& part, bool host) {
  EditScene scene = read_edit_scene(part.folders);
  const ObjectSet objects = read_objects(part.objects);
  if (part.select) {
    SceneSelector selector(scene, part.views, {part.masks, LabelledObjects::all(part.objects)});
    scene.there = selector.select(*part.select, part.where);
    if (!selects(scene.there.diffuse) || !selects(scene.there.faces))
      throw Error(
          ErrorKind::Input, fmt::format("'{}' selects nothing", part.name),
          {.where = part.where,
           .why = fmt::format("no {} is in: {}", selects(scene.there.diffuse) ? "face of the mesh" : "surfel", part.wanted),
           .hint = "vitrine edit PROJECT edits.yaml with the same 'select' reports boxes and components of the mesh",
           .code = "PART_SELECTS_NOTHING"});
  }
  for (size_t i = 0; !host && i < scene.there.diffuse.size(); ++i)
    if (scene.shows_sky(i)) scene.there.diffuse[i] = 0;
  scene = kept(std::move(scene));
  SplatScene& surfels = scene.trained.surfels;
  if (part.select) {
    surfels.opaque = SplatLayer();
    if (!host && !reflects(surfels.diffuse)) surfels.reflection = SplatLayer(LayerKind::Reflection, 0, 0);
  }
  ScenePart out{part.name, part.where, placed(std::move(scene), part.place), objects};
  out.objects.shapes = placed(objects.shapes, part.place);
  return out;
}

Json numbers(const Vec3d& v) { return {v.x, v.y, v.z}; }

Json described(const CompositionPart& part, const ScenePart& made) {
  Bounds3 box;
  for (const Vec3f& p : made.scene.mesh.positions) box.extend(cast<double>(p));
  const Mat3d& r = part.place.rotation;
  return {{"name", part.name},
          {"select", part.wanted},
          {"scale", part.place.scale},
          {"rotation", {numbers(transposed(r).c0), numbers(transposed(r).c1), numbers(transposed(r).c2)}},  // rows
          {"translation", numbers(part.place.translation)},
          {"surfels", made.scene.trained.surfels.diffuse.size()},
          {"mesh_faces", made.scene.mesh.faces.size()},
          {"box", {box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z}}};
}

// The label images of the host's photos show its objects, whose ids stay.
void write_object_table(const ObjectSet& objects, const std::optional<fs::path>& host, const fs::path& out) {
  if (objects.empty()) return;
  make_folders(out / "objects");
  write_objects(out / "objects", objects);
  std::error_code ec;
  if (!host || !fs::is_directory(*host / "objects/labels", ec)) return;
  for (const auto& e : fs::directory_iterator(*host / "objects/labels"))
    if (e.is_regular_file()) write_file(out / "objects/labels" / e.path().filename(), read_file(e.path()));
}

void warn(const std::vector<ScenePart>& made, StageContext& context) {
  std::vector<std::string> reflecting, dark;
  for (const ScenePart& p : made) {
    if (p.scene.trained.surfels.reflection.size() > 0) reflecting.push_back(p.name);
    if (!p.scene.materials) dark.push_back(p.name);
  }
  if (reflecting.size() > 1)
    context.warning("REFLECTIONS_MIX", fmt::format("mirrors of '{}' may show reflections of the others: vitrine relight traces "
                                                   "them anew",
                                                   fmt::join(reflecting, "', '")));
  if (!dark.empty())
    context.warning("NO_COMMON_LIGHT",
                    fmt::format("the composition cannot be relit: '{}' has no decomposition into albedo and light (vitrine run "
                                "PROJECT computes it)",
                                fmt::join(dark, "', '")));
}

}  // namespace

void describe(Describer&, ComposeConfig&) {}

void run_compose(const ComposeConfig&, StageContext& context) {
  const std::vector<CompositionPart> parts = read_composition(context.input("scene"));
  std::vector<ScenePart> made;
  Json report = {{"parts", Json::array()}};
  for (const CompositionPart& part : parts) {
    throw_if_interrupted();
    context.progress({.fraction = double(made.size()) / double(parts.size()), .text = part.name, .values = {}});
    made.push_back(scene_part(part, made.empty()));
    report["parts"].push_back(described(part, made.back()));
  }
  warn(made, context);
  const JoinedScene all = joined(std::move(made));
  for (size_t p = 0; p < parts.size(); ++p) report["parts"][p]["objects"] = all.ids[p];
  write_edit_scene(all.scene, parts.front().folders, context.output());
  write_object_table(all.objects, parts.front().objects, context.output());
  make_folders(context.output() / "compose");
  write_file(context.output() / "compose/report.json", readable(report));
  const size_t surfels = all.scene.trained.surfels.diffuse.size();
  context.metric("parts", double(parts.size()));
  context.metric("surfels", double(surfels));
  context.summary(fmt::format("{} {}, {} surfels", parts.size(), parts.size() == 1 ? "part" : "parts", surfels));
}

Stage compose_stage() {
  StageInfo info{
      .name = "compose",
      .version = 1,
      .summary = "several finished scenes, or objects of them, in one frame",
      .inputs = {
          {.name = "scene", .artifact = false, .doc = "The parts and their places: a YAML file.", .also = composition_files}}};
  return make_stage<ComposeConfig>(std::move(info), run_compose, [] {
    return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
  });
}

}  // namespace vitrine
