// Consistency of the surfels' object ids with the label images of held-out photos, which were not used to assign the ids.
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

  // IoU of each object between rendered_objects() and the labels, over all added photos.
  std::map<uint16_t, double> iou() const;
  // Share of the surfels visible in these photos whose id is the label of most of their pixels; nullopt without a photo or an id.
  // Surfels without id seen through thin glass are excluded.
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
