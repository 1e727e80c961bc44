#include "stages/view/page_surfels.h"

#include <algorithm>

#include "core/render/edit/selection.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint32_t kMostComponents = 255;  // one byte per surfel

// One byte per surfel of a layer.
struct LayerParts {
  std::vector<uint8_t> classes, components;
  void resize(size_t n) { classes.resize(n), components.resize(n); }
};

void take_components(const std::vector<uint32_t>& numbers, LayerParts& parts) {
  std::ranges::transform(numbers, parts.components.begin(),
                         [](uint32_t n) { return static_cast<uint8_t>(n <= kMostComponents ? n : 0); });
}
void take_class(const std::vector<uint8_t>& selected, MaskClass kind, LayerParts& parts) {
  for (size_t i = 0; i < selected.size(); ++i)
    if (selected[i]) parts.classes[i] = static_cast<uint8_t>(parts.classes[i] | 1 << static_cast<int>(kind));
}

}  // namespace

Json add_objects(const ObjectSet& set, const SplatScene& scene, const PageSurfels& surfels, PageBlocks& blocks) {
  Json list = Json::array();
  if (set.empty()) return list;
  for (const Object& o : set.objects)
    list.push_back({{"id", o.id}, {"name", o.name}, {"role", name(o.role)}, {"trust", name(o.trust)}});
  const auto id_at = [](std::span<const uint16_t> ids, uint32_t i) { return i < ids.size() ? ids[i] : uint16_t(0); };
  std::vector<uint16_t> ids;
  for (size_t k = 0; k < surfels.drawn; ++k) {
    const uint32_t i = surfels.of_diffuse[k];
    ids.push_back(i != UINT32_MAX ? id_at(scene.diffuse.object_ids(), i)
                                  : id_at(scene.transmittance.object_ids(), surfels.of_inside[k]));
  }
  blocks.words("part_object", ids, 1);
  return list;
}

Json no_edits(const std::string& why) { return {{"there", false}, {"why", why}}; }

Json add_edits(const EditScene& scene, std::span<const View> views, const ClassPixels& pixels, const PageSurfels& surfels,
               Json& shapes, PageBlocks& blocks) {
  const SplatLayer &diffuse = scene.trained.surfels.diffuse, &inside = scene.trained.surfels.transmittance;
  SceneSelector selector(scene, views, pixels);
  LayerParts of_diffuse, of_inside;
  of_diffuse.resize(diffuse.size()), of_inside.resize(inside.size());
  Json classes = Json::array();
  for (const MaskClass kind : selector.classes()) {
    const Parts parts = selector.select({.kind = kind}, "the page");
    take_class(parts.diffuse, kind, of_diffuse), take_class(parts.transmittance, kind, of_inside);
    classes.push_back(name(kind));
  }
  take_components(selector.surfel_components().diffuse, of_diffuse);
  take_components(selector.surfel_components().transmittance, of_inside);

  std::vector<uint8_t> kinds, components;
  std::vector<uint32_t> place(diffuse.size(), UINT32_MAX);  // index of a surfel in the rendered, then the absent ones
  for (size_t k = 0; k < surfels.drawn; ++k) {
    const uint32_t i = surfels.of_diffuse[k], j = surfels.of_inside[k];
    kinds.push_back(i != UINT32_MAX ? of_diffuse.classes[i] : of_inside.classes[j]);
    components.push_back(i != UINT32_MAX ? of_diffuse.components[i] : of_inside.components[j]);
    if (i != UINT32_MAX) place[i] = static_cast<uint32_t>(k);
  }
  blocks.bytes("part_class", kinds, 1);
  blocks.bytes("part_component", components, 1);

  std::vector<uint32_t> absent;
  for (uint32_t i = 0; i < place.size(); ++i)
    if (place[i] == UINT32_MAX) absent.push_back(i);
  sort_along_curve(diffuse, absent);
  kinds.clear(), components.clear();
  std::vector<uint8_t> flags;
  std::vector<uint16_t> objects;
  for (uint32_t k = 0; k < absent.size(); ++k) {
    const uint32_t i = absent[k];
    place[i] = static_cast<uint32_t>(surfels.drawn) + k;
    kinds.push_back(of_diffuse.classes[i]), components.push_back(of_diffuse.components[i]);
    flags.push_back(scene.shows_sky(i) ? kSkySurfel : 0);
    objects.push_back(diffuse.object_ids().empty() ? uint16_t(0) : diffuse.object_ids()[i]);
  }
  blocks.words("absent_place", page_places(diffuse, absent), 3);
  blocks.bytes("absent_class", kinds, 1);
  blocks.bytes("absent_component", components, 1);
  blocks.bytes("absent_flags", flags, 1);
  if (!selector.objects().known().empty()) blocks.words("absent_object", objects, 1);

  std::vector<uint32_t> members;
  for (size_t e = 0; e < shapes["entries"].size(); ++e) {
    const size_t before = members.size();
    for (size_t i = 0; i < diffuse.size(); ++i)
      if (shows_shape(scene.trained.image.shape.set->entries[e], diffuse, i)) members.push_back(place[i]);
    std::ranges::sort(members.begin() + static_cast<std::ptrdiff_t>(before), members.end());
    shapes["entries"][e]["surfels"] = members.size() - before;
  }
  blocks.indices("shape_surfel", members, 1);
  Json out{
      {"there", true}, {"classes", classes}, {"components", std::min<size_t>(kMostComponents, selector.components().size())}};
  if (classes.empty()) out["no_classes"] = "there are no masks (vitrine run ... --masks marks.yaml makes them)";
  return out;
}

}  // namespace vitrine
