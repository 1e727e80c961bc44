#include "stages/view/page_objects.h"

namespace vitrine {

nlohmann::ordered_json add_objects(const ObjectSet& set, const SplatScene& scene, const PageSurfels& surfels,
                                   PageBlocks& blocks) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
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

}  // namespace vitrine
