#include "stages/evaluate/object_agreement.h"

namespace vitrine {

void ObjectAgreement::add(LabelledView photo) {
  if (diffuse_.object_ids().empty()) return;
  const Image16 ours = rendered_objects(diffuse_, near_z_, photo.view);
  for (size_t p = 0; p < ours.pixel_count(); ++p) {
    const uint16_t a = ours.data()[p], b = photo.labels.data()[p];
    if (a != 0) ++pixels_[a].either;
    if (b != 0 && b != a) ++pixels_[b].either;
    if (a != 0 && a == b) ++pixels_[a].both;
  }
  photos_.push_back(std::move(photo));
}

std::map<uint16_t, double> ObjectAgreement::iou() const {
  std::map<uint16_t, double> out;
  for (const auto& [id, p] : pixels_) out[id] = double(p.both) / double(p.either);
  return out;
}

std::optional<double> ObjectAgreement::surfel_accuracy() const {
  if (photos_.empty()) return std::nullopt;
  const SurfelLabels shown = labels_of_surfels(diffuse_, near_z_, photos_);
  size_t seen = 0, same = 0;
  for (size_t i = 0; i < shown.label.size(); ++i)
    if (const uint16_t id = diffuse_.object_ids()[i]; shown.seen[i] && (id != 0 || !shows_thin_glass(objects_, shown.label[i])))
      ++seen, same += shown.label[i] == id;
  return seen > 0 ? std::optional(double(same) / double(seen)) : std::nullopt;
}

}  // namespace vitrine
