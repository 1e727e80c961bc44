#include "core/render/edit/selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/ranges.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"
#include "core/render/picture/part_labels.h"

namespace vitrine {

namespace {

constexpr float kInside = 0.5f;         // mask threshold
constexpr float kReachEdges = 3;        // in mean edge lengths of the mesh: surfels farther away belong to no component
constexpr size_t kNamedComponents = 5;  // number listed in the error message for a missing component
constexpr size_t kGrain = 256;

// Even-odd rule.
bool inside_polygon(const std::vector<Vec2d>& polygon, const Vec2d& p) {
  bool inside = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2d &a = polygon[i], &b = polygon[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
  }
  return inside;
}

Vec3d mean_of(const SplatLayer& layer, size_t i) {
  const float* m = layer.at(Attribute::Mean, i);
  return {double(m[0]), double(m[1]), double(m[2])};
}

float mean_edge(const TriMesh& mesh) {
  double sum = 0;
  for (const auto& f : mesh.faces)
    for (size_t k = 0; k < 3; ++k) sum += double(length(mesh.positions[f[(k + 1) % 3]] - mesh.positions[f[k]]));
  return float(sum / (3.0 * double(std::max<size_t>(1, mesh.faces.size()))));
}

void set_faces(const TriMesh& mesh, Parts& parts) {
  parts.faces.resize(mesh.faces.size());
  for (size_t f = 0; f < parts.faces.size(); ++f) {
    int corners = 0;
    for (uint32_t v : mesh.faces[f]) corners += parts.vertices[v];
    parts.faces[f] = corners >= 2;
  }
}

// Combines all flag lists: a = op(a, b).
template <class Op>
void combine(Parts& a, const Parts& b, Op&& op) {
  for (auto list : {&Parts::diffuse, &Parts::transmittance, &Parts::vertices, &Parts::faces, &Parts::walls, &Parts::content})
    for (size_t i = 0; i < (a.*list).size(); ++i) (a.*list)[i] = op((a.*list)[i], (b.*list)[i]);
}

template <class Ids>
std::vector<uint8_t> equal_to(const Ids& ids, uint16_t id) {
  std::vector<uint8_t> out(ids.size());
  std::ranges::transform(ids, out.begin(), [&](uint16_t other) { return uint8_t(other == id); });
  return out;
}

}  // namespace

SceneSelector::SceneSelector(const EditScene& scene, std::span<const View> views, ClassPixels pixels)
    : scene_(scene),
      views_(views),
      pixels_(std::move(pixels)),
      distance_(scene.mesh),
      reach_(kReachEdges * mean_edge(scene.mesh)) {
  const FaceComponents found = face_components(scene.mesh);
  std::vector<uint32_t> order(found.faces.size()), rank(order.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, [&](uint32_t a, uint32_t b) { return found.faces[a] > found.faces[b]; });
  for (uint32_t i = 0; i < order.size(); ++i) rank[order[i]] = i;
  components_.resize(order.size());
  component_of_face_.resize(scene.mesh.faces.size());
  for (size_t f = 0; f < component_of_face_.size(); ++f) {
    component_of_face_[f] = rank[found.label[f]];
    MeshComponent& component = components_[component_of_face_[f]];
    ++component.faces;
    for (uint32_t v : scene.mesh.faces[f]) component.box.extend(cast<double>(scene.mesh.positions[v]));
  }
}

Parts SceneSelector::select(const Selector& selector, const std::string& where) {
  Parts out = where_place([&](const Vec3d& p) {
    if (selector.box)
      for (size_t c = 0; c < 3; ++c)
        if (!(p[c] >= selector.box->low[c] && p[c] <= selector.box->high[c])) return false;
    return std::ranges::all_of(selector.marks, [&](const EditMark& mark) {
      const auto px = image_point(p, views_[mark.view]);
      return px && inside_polygon(mark.polygon, {px->x, px->y});
    });
  });
  const auto both = [](uint8_t a, uint8_t b) { return uint8_t(a && b); };
  if (selector.kind) combine(out, of_class(*selector.kind, where), both);
  if (selector.object) combine(out, of_object(*selector.object, where), both);
  if (selector.component) combine(out, of_component(*selector.component, where), both);
  for (const Selector& except : selector.except)
    combine(out, select(except, where), [](uint8_t a, uint8_t b) { return uint8_t(a && !b); });
  return out;
}

Parts SceneSelector::where_place(const std::function<bool(const Vec3d&)>& inside) const {
  const auto flags = [&](size_t n, const auto& place) {
    std::vector<uint8_t> out(n);
    parallel_for(n, kGrain, [&](size_t i) { out[i] = inside(place(i)); });
    return out;
  };
  const SplatScene& surfels = scene_.trained.surfels;
  Parts out;
  out.diffuse = flags(surfels.diffuse.size(), [&](size_t i) { return mean_of(surfels.diffuse, i); });
  out.transmittance = flags(surfels.transmittance.size(), [&](size_t i) { return mean_of(surfels.transmittance, i); });
  out.vertices = flags(scene_.mesh.positions.size(), [&](size_t v) { return cast<double>(scene_.mesh.positions[v]); });
  const TriMesh& walls = scene_.surroundings;
  out.walls = flags(walls.positions.size(), [&](size_t v) { return cast<double>(walls.positions[v]); });
  out.content = flags(scene_.content.positions.size(), [&](size_t v) { return cast<double>(scene_.content.positions[v]); });
  set_faces(scene_.mesh, out);
  return out;
}

Parts SceneSelector::of_component(size_t component, const std::string& where) const {
  if (component > components_.size()) {
    std::string largest;
    for (size_t i = 0; i < std::min(components_.size(), kNamedComponents); ++i) {
      const auto& [faces, box] = components_[i];
      largest += fmt::format("{}{}: {} faces in [{:.3g}, {:.3g}, {:.3g}, {:.3g}, {:.3g}, {:.3g}]", i > 0 ? "; " : "", i + 1,
                             faces, box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z);
    }
    throw Error(ErrorKind::Input, fmt::format("the mesh has no component {}", component),
                {.where = where,
                 .why = fmt::format("it has {}, from most faces to fewest", components_.size()),
                 .hint = largest,
                 .code = "EDIT_SELECTS_NOTHING"});
  }
  const auto wanted = uint32_t(component);
  const auto those = [&](const std::vector<uint32_t>& numbers) {
    std::vector<uint8_t> flags(numbers.size());
    for (size_t i = 0; i < flags.size(); ++i) flags[i] = numbers[i] == wanted;
    return flags;
  };
  Parts out;
  out.diffuse = those(surfel_components().diffuse);
  out.transmittance = those(surfel_components().transmittance);
  out.content.resize(scene_.content.positions.size());
  parallel_for(out.content.size(), kGrain,
               [&](size_t v) { out.content[v] = component_around(scene_.content.positions[v]) == wanted; });
  out.vertices.assign(scene_.mesh.positions.size(), 0);
  out.faces.resize(scene_.mesh.faces.size());
  for (size_t f = 0; f < out.faces.size(); ++f) {
    out.faces[f] = component_of_face_[f] + 1 == wanted;
    if (out.faces[f])
      for (uint32_t v : scene_.mesh.faces[f]) out.vertices[v] = 1;
  }
  out.walls.assign(scene_.surroundings.positions.size(), 0);
  return out;
}

uint32_t SceneSelector::component_near(const Vec3f& p) const {
  const ClosestPoint c = distance_.closest(p);
  return c.distance <= reach_ ? component_of_face_[c.face] + 1 : 0;
}

uint32_t SceneSelector::component_around(const Vec3f& p) const {
  const ClosestPoint c = distance_.closest(p);
  const auto& f = scene_.mesh.faces[c.face];
  const Vec3f &a = scene_.mesh.positions[f[0]], &b = scene_.mesh.positions[f[1]], &d = scene_.mesh.positions[f[2]];
  const bool behind = dot(p - c.position, cross(b - a, d - a)) < 0;
  return behind || c.distance <= reach_ ? component_of_face_[c.face] + 1 : 0;
}

const SceneSelector::SurfelComponents& SceneSelector::surfel_components() const {
  if (surfel_components_) return *surfel_components_;
  const auto numbers = [&](const SplatLayer& layer, auto component) {
    std::vector<uint32_t> out(layer.size());
    parallel_for(out.size(), kGrain, [&](size_t i) { out[i] = (this->*component)(cast<float>(mean_of(layer, i))); });
    return out;
  };
  const SplatScene& surfels = scene_.trained.surfels;
  return surfel_components_.emplace(numbers(surfels.diffuse, &SceneSelector::component_near),
                                    numbers(surfels.transmittance, &SceneSelector::component_around));
}

std::vector<MaskClass> SceneSelector::classes() const {
  std::vector<MaskClass> out;
  for (const MaskClass kind : kMaskClasses)
    if (pixels_.has(kind) && std::ranges::any_of(views_, [&](const View& v) { return pixels_.of(kind, v).has_value(); }))
      out.push_back(kind);
  return out;
}

const Parts& SceneSelector::of_class(MaskClass kind, const std::string& where) {
  if (const auto known = classes_.find(kind); known != classes_.end()) return known->second;
  std::vector<LabelledView> views;  // label 1: inside the mask
  for (View view : views_) {
    throw_if_interrupted();
    const auto mask = pixels_.of(kind, view);
    if (!mask) continue;
    view.intrinsics = view.intrinsics.limited_to(kLabelSide);
    const ImageF small = resized(*mask, view.intrinsics.width, view.intrinsics.height);
    Image16 labels(small.width(), small.height(), 1);
    std::ranges::transform(small.data(), labels.data().begin(), [](float v) { return uint16_t(v > kInside); });
    views.push_back({view, std::move(labels)});
  }
  if (views.empty())
    throw Error(ErrorKind::Input, fmt::format("this scene has no masks of the class '{}'", name(kind)),
                {.where = where,
                 .why = "nothing of this class is marked, or the stages masks and objects have not been computed",
                 .hint = "vitrine run ... --masks marks.yaml makes them; boxes, marks and components need none",
                 .code = "NO_MASKS"});
  const SplatScene& surfels = scene_.trained.surfels;
  const auto places = [&](size_t count, const auto& place) { return equal_to(labels_of_places(count, place, views), 1); };
  Parts out;
  out.diffuse = equal_to(labels_of_surfels(surfels.diffuse, scene_.trained.image.diffuse.near_z, views).label, 1);
  out.transmittance = places(surfels.transmittance.size(), [&](size_t i) { return mean_of(surfels.transmittance, i); });
  out.content = places(scene_.content.positions.size(), [&](size_t v) { return cast<double>(scene_.content.positions[v]); });
  out.vertices = equal_to(labels_of_vertices(scene_.mesh, views), 1);
  out.walls.assign(scene_.surroundings.positions.size(), 0);
  set_faces(scene_.mesh, out);
  return classes_[kind] = std::move(out);
}

Parts SceneSelector::of_object(const std::string& name, const std::string& where) const {
  const std::vector<Object>& objects = pixels_.objects().objects;
  const auto object = std::ranges::find(objects, name, &Object::name);
  if (object == objects.end()) {
    std::vector<std::string> names;
    for (const Object& o : objects) names.push_back(o.name);
    throw Error(ErrorKind::Input, fmt::format("this scene has no object '{}'", name),
                {.where = where,
                 .why = names.empty() ? std::string("its table of objects is empty, or the stage objects has not been computed")
                                      : fmt::format("its objects are: {}", fmt::join(names, ", ")),
                 .hint = "objects/objects.json has the names; vitrine run ... --masks marks.yaml gives them",
                 .code = "NO_OBJECT"});
  }
  const SplatScene& surfels = scene_.trained.surfels;
  const auto those = [&](std::span<const uint16_t> ids, size_t count) {
    return ids.empty() ? std::vector<uint8_t>(count, 0) : equal_to(ids, object->id);
  };
  Parts out;
  out.diffuse = those(surfels.diffuse.object_ids(), surfels.diffuse.size());
  out.transmittance = those(surfels.transmittance.object_ids(), surfels.transmittance.size());
  out.vertices = those(scene_.mesh.object_ids, scene_.mesh.positions.size());
  out.content = those(scene_.content.object_ids, scene_.content.positions.size());
  out.walls.assign(scene_.surroundings.positions.size(), 0);
  set_faces(scene_.mesh, out);
  return out;
}

}  // namespace vitrine
