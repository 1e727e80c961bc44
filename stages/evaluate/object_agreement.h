// How the ids of objects that surfels carry agree with the label images of held-out photos, which took no part in giving them.
#pragma once

#include <map>
#include <optional>

#include "core/render/picture/part_labels.h"

namespace vitrine {

class ObjectAgreement {
 public:
  // All must outlive it. `near_z`: of the rasteriser.
  ObjectAgreement(const SplatLayer& diffuse, float near_z, const ObjectSet& objects)
      : diffuse_(diffuse), near_z_(near_z), objects_(objects) {}
  void add(LabelledView photo);

  // Of each object: pixels of the photos that show it by both, over those that show it by either; rendered_objects() and labels.
  std::map<uint16_t, double> iou() const;
  // Share of the surfels that these photos show whose id is the label of most of their pixels; nullopt without a photo or an id.
  // What has no id and is seen through thin glass counts for neither.
  std::optional<double> surfel_accuracy() const;

 private:
  struct Pixels {
    size_t both = 0, either = 0;
  };
  const SplatLayer& diffuse_;
  float near_z_;
  const ObjectSet& objects_;
  std::vector<LabelledView> photos_;
  std::map<uint16_t, Pixels> pixels_;
};

}  // namespace vitrine
