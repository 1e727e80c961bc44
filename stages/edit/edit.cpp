#include "stages/edit/edit.h"

#include <algorithm>
#include <numeric>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/render/edit/edit_scene.h"
#include "core/render/edit/selection.h"
#include "core/render/raster/renderer.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr float kOpenEnd = 1e-4f;         // clamp of values before the inverse sigmoid, which diverges at 0 and 1
constexpr double kMostScatter_rel = 0.5;  // largest mean free path
constexpr size_t kListedComponents = 20;  // maximum number listed in the report

struct Counts {
  size_t diffuse = 0, transmittance = 0, vertices = 0, faces = 0, walls = 0, content = 0;
  size_t sum() const { return diffuse + transmittance + vertices + faces + walls + content; }
};

size_t count(const std::vector<uint8_t>& flags) { return size_t(std::accumulate(flags.begin(), flags.end(), 0L)); }

float raw(float value) { return logit(std::clamp(value, kOpenEnd, 1 - kOpenEnd)); }

// Tints the radiance like the albedo, which it is proportional to:  L = 0.5 + Y_0 h_0 + ...
void tint_light(SplatLayer& layer, size_t i, const Vec3f& tint) {
  for (size_t c = 0; c < 3; ++c) {
    float& dc = layer.at(Attribute::ShDc, i)[c];
    dc = (tint[c] * (0.5f + kShDc * dc) - 0.5f) / kShDc;
    for (size_t k = c; k < layer.width(Attribute::ShRest); k += 3) layer.at(Attribute::ShRest, i)[k] *= tint[c];
  }
}

Vec3f tinted(const Vec3f& color, const Vec3f& tint) {
  return {std::clamp(color.x * tint.x, 0.f, 1.f), std::clamp(color.y * tint.y, 0.f, 1.f), std::clamp(color.z * tint.z, 0.f, 1.f)};
}

// Mean free path per channel, scene units.
Vec3f scene_length(const Edit& edit, const fs::path& sfm) {
  const Scatter& s = *edit.set.scatter;
  double length = s.length;
  if (s.metres) {
    const auto metres_per_unit = read_scene_info(sfm / "scene.json").metres_per_unit();
    if (!metres_per_unit)
      throw Error(ErrorKind::Input, fmt::format("'{}': the size of the scene in metres is not known", edit.name),
                  {.where = edit.where,
                   .why = "'scatter' has a unit, and neither given poses nor GPS gave the scene one",
                   .hint = "give a number: units of the scene, in which the ring of cameras has radius 1",
                   .code = "EDIT_UNIT"});
    length /= *metres_per_unit;
  }
  if (length > kMostScatter_rel)
    throw Error(ErrorKind::Input, fmt::format("'{}': light does not scatter that far below a surface", edit.name),
                {.where = edit.where,
                 .why = fmt::format("{:.3g} scene units are more than {} of the camera ring's radius", length, kMostScatter_rel),
                 .hint = "wax and marble: a few millimetres",
                 .code = "EDIT_UNIT"});
  return float(length) * s.color;
}

// Direction of the marks times the anisotropy; around an axis through `middle` where the metal was turned.
Vec3f marks_at(const BrushMarks& marks, const Vec3f& place, const Vec3f& middle) {
  if (!marks.turned) return marks.anisotropy * marks.direction;
  const Vec3f around = cross(marks.direction, place - middle);
  return squared_length(around) > 0 ? marks.anisotropy * normalized(around) : Vec3f{};
}

Vec3f mean_place(const SplatLayer& layer, const std::vector<uint8_t>& selected) {
  Vec3d sum{};
  size_t n = 0;
  for (size_t i = 0; i < selected.size(); ++i) {
    if (!selected[i]) continue;
    const float* p = layer.at(Attribute::Mean, i);
    sum += Vec3d{p[0], p[1], p[2]}, ++n;
  }
  return n > 0 ? cast<float>(sum / double(n)) : Vec3f{};
}

void change_surfel(EditScene& scene, size_t i, const MaterialChange& set, const std::optional<Vec3f>& scatter) {
  SplatLayer& layer = scene.trained.surfels.diffuse;
  if (set.tint) tint_light(layer, i, *set.tint);
  if (set.f0)
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::F0, i)[c] = raw((*set.f0)[c]);
  if (set.roughness) *layer.at(Attribute::Roughness, i) = raw(*set.roughness);
  if (set.specular_weight) *layer.at(Attribute::SpecularWeight, i) = raw(*set.specular_weight);
  if (set.transmission) *layer.at(Attribute::Transmission, i) = raw(*set.transmission);
  if (!scene.materials) return;
  DecomposedMaterials& m = *scene.materials;
  if (set.tint) m.albedo[i] = tinted(m.albedo[i], *set.tint);
  if (set.f0) m.f0[i] = *set.f0;
  if (set.roughness) m.roughness[i] = *set.roughness;
  if (set.specular_weight) m.specular_weight[i] = *set.specular_weight;
  if (set.transmission) m.transmission[i] = *set.transmission;
  if (scatter) m.scatter[i] = *scatter;
  if (m.shows_sky(i)) m.f0[i] = {kOpenEnd, kOpenEnd, kOpenEnd};  // a black surface: all values 0 would mark the sky
}

Counts change(EditScene& scene, const Parts& parts, const Edit& edit, const fs::path& sfm) {
  Counts n;
  std::optional<Vec3f> scatter;
  if (edit.set.scatter) scatter = scene_length(edit, sfm);
  if (scatter && scene.materials) scene.materials->scatter.resize(scene.materials->size());
  const SplatLayer& layer = scene.trained.surfels.diffuse;
  if (edit.set.marks && scene.materials) {
    scene.materials->marks.resize(scene.materials->size());
    const Vec3f middle = mean_place(layer, parts.diffuse);
    for (size_t i = 0; i < parts.diffuse.size(); ++i)
      if (const float* p = layer.at(Attribute::Mean, i); parts.diffuse[i])
        scene.materials->marks[i] = marks_at(*edit.set.marks, {p[0], p[1], p[2]}, middle);
  }
  for (size_t i = 0; i < parts.diffuse.size(); ++i)
    if (parts.diffuse[i] && !scene.shows_sky(i)) change_surfel(scene, i, edit.set, scatter), ++n.diffuse;
  if (!edit.set.tint) return n;
  // Content behind glass has only an albedo. Classes and components select the glass, not its content.
  if (edit.select.geometric())
    for (size_t i = 0; i < parts.transmittance.size(); ++i) {
      if (!parts.transmittance[i]) continue;
      tint_light(scene.trained.surfels.transmittance, i, *edit.set.tint), ++n.transmittance;
      if (!scene.materials || scene.materials->albedo_behind_glass.empty()) continue;
      Vec3f& albedo = scene.materials->albedo_behind_glass[i];
      albedo = tinted(albedo, *edit.set.tint);
    }
  const auto tint_vertices = [&](TriMesh& mesh, const std::vector<uint8_t>& vertices, size_t& changed) {
    for (size_t v = 0; v < mesh.colors.size(); ++v)
      if (vertices[v]) mesh.colors[v] = tinted(mesh.colors[v], *edit.set.tint), ++changed;
  };
  tint_vertices(scene.mesh, parts.vertices, n.vertices);
  tint_vertices(scene.surroundings, parts.walls, n.walls);
  if (edit.select.geometric()) tint_vertices(scene.content, parts.content, n.content);
  return n;
}

Counts remove(EditScene& scene, const Parts& parts) {
  const auto drop = [](std::vector<uint8_t>& there, const std::vector<uint8_t>& selected) {
    for (size_t i = 0; i < there.size(); ++i) there[i] = there[i] && !selected[i];
    return count(selected);
  };
  Counts n;
  n.diffuse = drop(scene.there.diffuse, parts.diffuse);
  n.transmittance = drop(scene.there.transmittance, parts.transmittance);
  n.vertices = drop(scene.there.vertices, parts.vertices);
  n.faces = drop(scene.there.faces, parts.faces);
  n.walls = drop(scene.there.walls, parts.walls);
  n.content = drop(scene.there.content, parts.content);
  return n;
}

[[noreturn]] void refuse_empty(const EditScene& scene, const Edit& edit) {
  Bounds3 box;
  for (const Vec3f& p : scene.mesh.positions) box.extend(cast<double>(p));
  const bool some_deleted = count(scene.there.diffuse) < scene.there.diffuse.size();
  throw Error(ErrorKind::Input, fmt::format("'{}' selects nothing", edit.name),
              {.where = edit.where,
               .why = fmt::format("no surfel and no part of the mesh{} is in: {}", some_deleted ? " that is still there" : "",
                                  edit.wanted),
               .hint = fmt::format("the mesh lies between [{:.3g}, {:.3g}, {:.3g}] and [{:.3g}, {:.3g}, {:.3g}]; classes and "
                                   "objects: objects/contact_sheet.png; pixels of marks: images/",
                                   box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z),
               .code = "EDIT_SELECTS_NOTHING"});
}

void refuse_to_delete_all(const Edit& edit, const char* what) {
  throw Error(ErrorKind::Input, fmt::format("'{}' deletes all that is left of the {}", edit.name, what),
              {.where = edit.where,
               .why = fmt::format("it selects: {}", edit.wanted),
               .hint = "select less; 'except' leaves parts out",
               .code = "EDIT_DELETES_ALL"});
}

// Shortest decimal that parses to the same float (a double would print 17 digits).
double short_number(float v) { return std::stod(fmt::format("{}", v)); }
Json numbers(const Vec3f& v) { return {short_number(v.x), short_number(v.y), short_number(v.z)}; }

Json described(const Edit& edit, const Counts& n) {
  Json json = {{"name", edit.name}, {"select", edit.wanted}};
  if (edit.remove) json["delete"] = true;
  const MaterialChange& set = edit.set;
  if (set.tint) json["set"]["tint"] = numbers(*set.tint);
  if (set.f0) json["set"]["f0"] = numbers(*set.f0);
  if (set.roughness) json["set"]["roughness"] = short_number(*set.roughness);
  if (set.specular_weight) json["set"]["k_s"] = short_number(*set.specular_weight);
  if (set.transmission) json["set"]["tau"] = short_number(*set.transmission);
  if (set.scatter) {
    json["set"]["scatter"] = fmt::format("{}{}", set.scatter->length, set.scatter->metres ? " m" : "");
    json["set"]["scatter_color"] = numbers(set.scatter->color);
  }
  if (set.marks) {
    json["set"][set.marks->turned ? "turned" : "brushed"] = numbers(set.marks->direction);
    json["set"]["anisotropy"] = short_number(set.marks->anisotropy);
  }
  json["surfels"] = n.diffuse;
  json["surfels_behind_glass"] = n.transmittance;
  json["mesh_vertices"] = n.vertices;
  if (edit.remove) json["mesh_faces"] = n.faces;
  json["surroundings_vertices"] = n.walls;
  json["behind_glass_vertices"] = n.content;
  return json;
}

Json described(const std::vector<MeshComponent>& components) {
  Json list = Json::array();
  for (size_t i = 0; i < std::min(components.size(), kListedComponents); ++i) {
    const Bounds3& b = components[i].box;
    list.push_back({{"component", i + 1},
                    {"faces", components[i].faces},
                    {"box", {b.low.x, b.low.y, b.low.z, b.high.x, b.high.y, b.high.z}}});
  }
  return list;
}

}  // namespace

void describe(Describer&, EditConfig&) {}

void run_edit(const EditConfig&, StageContext& context) {
  const std::vector<View> views = load_view_set(context.input("sfm"), context.input("optimize")).views;
  const fs::path file = context.input("edits");
  const std::vector<Edit> edits = read_edits(file, views);
  const EditFolders folders{.optimize = context.input("optimize"),
                            .mesh = context.input("mesh"),
                            .refine = context.optional_input("refine"),
                            .decompose = context.optional_input("decompose")};
  EditScene scene = read_edit_scene(folders);
  SceneSelector selector(scene, views,
                         {context.optional_input("masks"), LabelledObjects::all(context.optional_input("objects"))});
  Json report = {{"edits", Json::array()}};
  for (const Edit& edit : edits) {
    throw_if_interrupted();
    context.progress({.fraction = double(report["edits"].size()) / double(edits.size()), .text = edit.name, .values = {}});
    Parts parts = selector.select(edit.select, edit.where);
    const auto still_there = [](std::vector<uint8_t>& flags, const std::vector<uint8_t>& there) {
      for (size_t i = 0; i < flags.size(); ++i) flags[i] = flags[i] && there[i];
    };
    still_there(parts.diffuse, scene.there.diffuse);
    still_there(parts.transmittance, scene.there.transmittance);
    still_there(parts.vertices, scene.there.vertices);
    still_there(parts.faces, scene.there.faces);
    still_there(parts.walls, scene.there.walls);
    still_there(parts.content, scene.there.content);
    const Counts n = edit.remove ? remove(scene, parts) : change(scene, parts, edit, context.input("sfm"));
    if (n.sum() == 0) refuse_empty(scene, edit);
    if (count(scene.there.diffuse) == 0) refuse_to_delete_all(edit, "surfels");
    if (count(scene.there.faces) == 0) refuse_to_delete_all(edit, "mesh");
    if (edit.set.transmission && scene.trained.surfels.transmittance.size() == 0)
      context.warning("NO_GLASS",
                      fmt::format("{}: the scene was trained without glass, so nothing is seen through it", edit.name));
    if ((edit.set.scatter || edit.set.marks) && !scene.materials)
      context.warning(
          "NO_MATERIALS",
          fmt::format("{}: light below the surface and brush marks show under another light only, and the scene has no materials",
                      edit.name));
    report["edits"].push_back(described(edit, n));
  }
  report["components"] = described(selector.components());
  report["components_in_all"] = selector.components().size();
  const fs::path out = context.output() / "edited";
  const size_t before = scene.there.diffuse.size(), surfels = count(scene.there.diffuse);
  scene.trained.surfels.opaque = SplatLayer();  // the opaque twin contains the scene before all edits
  write_edit_scene(kept(std::move(scene)), folders, out);
  write_file(out / "edits.yaml", read_file(file));
  write_file(out / "report.json", report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  context.metric("edits", double(edits.size()));
  context.metric("surfels", double(surfels));
  context.metric("deleted", double(before - surfels));
  context.summary(fmt::format("{} {}; {} of {} surfels deleted", edits.size(), edits.size() == 1 ? "edit" : "edits",
                              before - surfels, before));
}

Stage edit_stage() {
  StageInfo info{
      .name = "edit",
      .version = 8,
      .summary = "changes to a finished scene",
      .inputs = {{.name = "sfm", .doc = "Cameras of the photos."},
                 {.name = "optimize", .doc = "The trained surfels."},
                 {.name = "mesh", .doc = "The mesh."},
                 {.name = "refine", .optional = true, .doc = "Better surfels behind glass."},
                 {.name = "decompose", .optional = true, .doc = "Materials freed of the light of the photos."},
                 {.name = "masks", .optional = true, .doc = "Which pixels show the object, and which are to be ignored."},
                 {.name = "objects", .optional = true, .doc = "Which pixels show glass, mirrors and coats."},
                 {.name = "edits", .artifact = false, .doc = "What to change: a YAML file."}}};
  return make_stage<EditConfig>(std::move(info), run_edit, [] {
    return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
  });
}

}  // namespace vitrine
