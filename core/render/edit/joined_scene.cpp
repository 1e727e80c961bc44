#include "core/render/edit/joined_scene.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/render/model/thick_glass.h"

namespace vitrine {

namespace {

constexpr uint16_t kMostObjects = 65534;  // 16-bit labels, two values are reserved
constexpr Vec3f kGrey{0.5f, 0.5f, 0.5f};  // of vertices without a colour in a mesh where others have one

// Position of an element of the union.
struct Origin {
  size_t part, index;
};

// The first `heads[part]` elements of all parts, then the rest of all parts.
std::vector<Origin> order_of(const std::vector<size_t>& sizes, const std::vector<size_t>& heads) {
  std::vector<Origin> out;
  for (size_t p = 0; p < sizes.size(); ++p)
    for (size_t i = 0; i < heads[p]; ++i) out.push_back({p, i});
  for (size_t p = 0; p < sizes.size(); ++p)
    for (size_t i = heads[p]; i < sizes[p]; ++i) out.push_back({p, i});
  return out;
}

SplatLayer joined_layer(const std::vector<const SplatLayer*>& layers, const std::vector<Origin>& order) {
  int degree = 0;
  bool labelled = false;
  for (const SplatLayer* layer : layers)
    degree = std::max(degree, layer->sh_degree()), labelled = labelled || !layer->object_ids().empty();
  SplatLayer out(layers.front()->kind(), degree, order.size());
  std::vector<uint16_t> ids(labelled ? order.size() : 0);
  for (size_t to = 0; to < order.size(); ++to) {
    const SplatLayer& from = *layers[order[to].part];
    const size_t i = order[to].index;
    for (const AttributeRow& row : kAttributes)  // a lower degree has a prefix of the coefficients
      std::copy_n(from.at(row.id, i), from.width(row.id), out.at(row.id, to));
    if (!from.object_ids().empty()) ids[to] = from.object_ids()[i];
  }
  out.set_object_ids(std::move(ids));
  return out;
}

// A part without values has those of T{}; empty if no part has some.
template <class T>
std::vector<T> joined_values(const std::vector<ScenePart>& parts, const std::vector<Origin>& order,
                             std::vector<T> DecomposedMaterials::*member) {
  const auto of = [&](const ScenePart& p) -> const std::vector<T>& { return (*p.scene.materials).*member; };
  std::vector<T> out;
  if (std::ranges::all_of(parts, [&](const ScenePart& p) { return of(p).empty(); })) return out;
  for (const Origin& o : order) out.push_back(of(parts[o.part]).empty() ? T{} : of(parts[o.part])[o.index]);
  return out;
}

// Appends a per-vertex attribute that either mesh may lack.
template <class T>
void append_values(std::vector<T>& to, size_t before, const std::vector<T>& more, size_t count, const T& missing) {
  if (to.empty() && more.empty()) return;
  to.resize(before, missing);
  to.insert(to.end(), more.begin(), more.end());
  to.resize(before + count, missing);
}

void append(TriMesh& to, const TriMesh& more) {
  const size_t before = to.positions.size(), count = more.positions.size();
  if (count == 0) return;
  if (before == 0) {
    to = more;
    return;
  }
  if (to.normals.empty() || more.normals.empty())
    to.normals.clear();  // readers compute those of all vertices
  else
    to.normals.insert(to.normals.end(), more.normals.begin(), more.normals.end());
  append_values(to.colors, before, more.colors, count, kGrey);
  append_values(to.object_ids, before, more.object_ids, count, uint16_t(0));
  to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
  for (auto face : more.faces) {
    for (uint32_t& v : face) v += uint32_t(before);
    to.faces.push_back(face);
  }
}

// Calls visit(ids, count) for the object ids of everything that has some, with the number of its elements.
template <class Visit>
void for_all_ids(EditScene& scene, const Visit& visit) {
  SplatScene& surfels = scene.trained.surfels;
  for (SplatLayer* layer : {&surfels.diffuse, &surfels.transmittance, &surfels.opaque}) {
    std::vector<uint16_t> ids(layer->object_ids().begin(), layer->object_ids().end());
    visit(ids, layer->size());
    layer->set_object_ids(std::move(ids));
  }
  for (TriMesh* mesh : {&scene.mesh, &scene.content, &scene.surroundings}) visit(mesh->object_ids, mesh->positions.size());
}

std::string free_name(const ObjectSet& objects, const std::string& wanted) {
  const auto taken = [&](const std::string& name) {
    return std::ranges::any_of(objects.objects, [&](const Object& o) { return o.name == name; });
  };
  std::string name = wanted;
  for (int i = 2; taken(name); ++i) name = fmt::format("{}_{}", wanted, i);
  return name;
}

// Adds the objects of a guest to the table and gives its surfels, vertices and shapes their new ids.
std::vector<uint16_t> take_objects(ScenePart& part, ObjectSet& table) {
  std::set<uint16_t> used;
  for_all_ids(part.scene, [&](std::vector<uint16_t>& ids, size_t count) {
    ids.resize(count, 0);
    used.insert(ids.begin(), ids.end());
  });
  const ShapeSet* shapes = part.scene.trained.image.shape.set.get();
  if (shapes != nullptr)
    for (const ShapeSet::Entry& e : shapes->entries) used.insert(e.object);
  std::vector<uint16_t> renumbered(size_t(UINT16_MAX) + 1, 0), own;
  uint16_t last = table.objects.empty() ? uint16_t(0) : table.objects.back().id;
  std::vector<uint8_t> stays(part.objects.shapes.entries.size());
  // Borders of labelled parts may have no label: an object of the part's name is for surfels.
  const auto surfels = part.scene.trained.surfels.diffuse.object_ids();
  const bool labelled = std::ranges::find(surfels, uint16_t(0)) == surfels.end();
  if (labelled && used.size() > 1) used.erase(0);
  for (const uint16_t id : used) {
    if (last >= kMostObjects)
      throw Error(ErrorKind::Input, "the composition has no free object id left",
                  {.where = part.where,
                   .why = fmt::format("a table of objects has an id of {}", last),
                   .hint = "smaller ids in objects/objects.json of the first part",
                   .code = "TOO_MANY_OBJECTS"});
    const Object* known = part.objects.find(id);
    Object object = known != nullptr ? *known : Object{.name = part.name};  // unlabelled, or of an object the table lacks
    object.id = ++last, object.name = free_name(table, object.name);
    renumbered[id] = last;
    own.push_back(last);
    table.objects.push_back(std::move(object));
    for (size_t i = 0; known != nullptr && i < stays.size(); ++i) stays[i] |= part.objects.shapes.entries[i].object == id;
  }
  if (renumbered[0] == 0) renumbered[0] = own.front();
  const auto renumber = [&](ShapeSet set) {
    for (ShapeSet::Entry& e : set.entries) e.object = renumbered[e.object];
    return set;
  };
  table.shapes.append(renumber(part.objects.shapes.kept(stays)));
  if (shapes != nullptr) part.scene.trained.image.shape.set = std::make_shared<const ShapeSet>(renumber(*shapes));
  for_all_ids(part.scene, [&](std::vector<uint16_t>& ids, size_t) {
    for (uint16_t& id : ids) id = renumbered[id];
  });
  return own;
}

void check_alike(const ScenePart& a, const ScenePart& b) {
  const ImageOptions &x = a.scene.trained.image, &y = b.scene.trained.image;
  const char* what = x.composite.blend != y.composite.blend         ? "blend"
                     : x.reflection.lobe != y.reflection.lobe       ? "lobe"
                     : x.transmission.glass != y.transmission.glass ? "glass"
                                                                    : nullptr;
  if (what == nullptr) return;
  throw Error(ErrorKind::Input, fmt::format("'{}' and '{}' were trained with another image formation", a.name, b.name),
              {.where = b.where,
               .why = fmt::format("'{}' differs in optimize/model.json of the two", what),
               .hint = "train both with the same options of the stage optimize",
               .code = "PARTS_DIFFER"});
}

// The options of the first layered part, with the shapes and the solid glass of all.
ImageOptions joined_options(const std::vector<ScenePart>& parts) {
  const ScenePart* base = &parts.front();
  for (const ScenePart& p : parts)
    if (is_layered(p.scene)) {
      if (!is_layered(base->scene)) base = &p;
      check_alike(*base, p);
    }
  ImageOptions out = base->scene.trained.image;
  out.medium = parts.front().scene.trained.image.medium;  // water or haze of the host
  ShapeSet shapes;
  TriMesh glass;
  float ior = 0, tolerance = 0;
  size_t mirrored = 0;
  bool guesses = false;
  for (const ScenePart& p : parts) {
    const ImageOptions& image = p.scene.trained.image;
    const size_t surfels = p.scene.trained.surfels.diffuse.size();
    mirrored += std::min(image.panes.mirrored, surfels), guesses = guesses || image.panes.mirrored != SIZE_MAX;
    if (image.shape.set) shapes.append(*image.shape.set);
    if (!image.transmission.thick) continue;
    append(glass, image.transmission.thick->mesh());
    ior = ior > 0 ? ior : image.transmission.thick->ior();  // solid glass of one scene has one index
    tolerance = std::max(tolerance, image.transmission.thick->tolerance());
  }
  out.panes.mirrored = guesses ? mirrored : SIZE_MAX;
  out.shape.set = shapes.entries.empty() ? nullptr : std::make_shared<const ShapeSet>(std::move(shapes));
  out.transmission.thick = glass.faces.empty() ? nullptr : std::make_shared<const ThickGlass>(std::move(glass), ior, tolerance);
  return out;
}

SplatScene joined_surfels(const std::vector<ScenePart>& parts, const std::vector<Origin>& order) {
  const auto all = [&](const auto& layer_of) {
    std::vector<const SplatLayer*> layers;
    for (const ScenePart& p : parts) layers.push_back(&layer_of(p.scene.trained.surfels));
    return layers;
  };
  const auto in_order = [](const std::vector<const SplatLayer*>& layers) {
    std::vector<size_t> sizes;
    for (const SplatLayer* layer : layers) sizes.push_back(layer->size());
    return joined_layer(layers, order_of(sizes, sizes));
  };
  SplatScene out;
  out.diffuse = joined_layer(all([](const SplatScene& s) -> const SplatLayer& { return s.diffuse; }), order);
  out.reflection = in_order(all([](const SplatScene& s) -> const SplatLayer& { return s.reflection; }));
  out.transmittance = in_order(all([](const SplatScene& s) -> const SplatLayer& { return s.transmittance; }));
  if (std::ranges::any_of(parts, [](const ScenePart& p) { return p.scene.trained.surfels.opaque.size() > 0; }))
    out.opaque =
        in_order(all([](const SplatScene& s) -> const SplatLayer& { return s.opaque.size() > 0 ? s.opaque : s.diffuse; }));
  return out;
}

std::optional<DecomposedMaterials> joined_materials(const std::vector<ScenePart>& parts, const std::vector<Origin>& order) {
  if (std::ranges::any_of(parts, [](const ScenePart& p) { return !p.scene.materials; })) return std::nullopt;
  DecomposedMaterials m{.albedo = joined_values(parts, order, &DecomposedMaterials::albedo),
                        .roughness = joined_values(parts, order, &DecomposedMaterials::roughness),
                        .f0 = joined_values(parts, order, &DecomposedMaterials::f0),
                        .specular_weight = joined_values(parts, order, &DecomposedMaterials::specular_weight),
                        .transmission = joined_values(parts, order, &DecomposedMaterials::transmission),
                        .albedo_behind_glass = {},
                        .scatter = joined_values(parts, order, &DecomposedMaterials::scatter),
                        .marks = joined_values(parts, order, &DecomposedMaterials::marks)};
  for (const ScenePart& p : parts) {
    const std::vector<Vec3f>& behind = p.scene.materials->albedo_behind_glass;
    if (behind.size() != p.scene.trained.surfels.transmittance.size()) {  // unknown for one: unknown for all
      m.albedo_behind_glass.clear();
      break;
    }
    m.albedo_behind_glass.insert(m.albedo_behind_glass.end(), behind.begin(), behind.end());
  }
  return m;
}

}  // namespace

bool is_layered(const EditScene& scene) {
  const SplatScene& surfels = scene.trained.surfels;
  return surfels.reflection.size() > 0 || surfels.transmittance.size() > 0 || scene.trained.image.shape.set != nullptr;
}

JoinedScene joined(std::vector<ScenePart> parts) {
  JoinedScene out;
  out.objects = parts.front().objects;
  std::vector<uint16_t> host;
  for (const Object& o : out.objects.objects) host.push_back(o.id);
  out.ids.push_back(std::move(host));
  for (size_t p = 1; p < parts.size(); ++p) out.ids.push_back(take_objects(parts[p], out.objects));
  if (parts.size() == 1) {
    out.scene = std::move(parts.front().scene);
    return out;
  }
  std::vector<size_t> sizes, heads;
  for (const ScenePart& p : parts) {
    sizes.push_back(p.scene.trained.surfels.diffuse.size());
    heads.push_back(std::min(sizes.back(), p.scene.trained.image.panes.mirrored));
  }
  const std::vector<Origin> order = order_of(sizes, heads);
  out.scene.trained = {joined_surfels(parts, order), joined_options(parts)};
  out.scene.materials = joined_materials(parts, order);
  for (const ScenePart& p : parts)
    for (TriMesh EditScene::*mesh : {&EditScene::mesh, &EditScene::surroundings, &EditScene::content})
      append(out.scene.*mesh, p.scene.*mesh);
  out.scene.keep_all();
  return out;
}

}  // namespace vitrine
