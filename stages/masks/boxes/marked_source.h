// Masks from a few marks of the user. A mark is a cone in space; the intersection of the cones of all marked photos is the
// object's visual hull, which is then rendered in every view:
//   glass    its outline in the other photos is that of the hull
//   mirrors  marked with boxes: no colour segmentation; the background predicted behind the hull is compared (outlines.h)
//   others   GrabCut (Rother et al. 2004) segments the outline near that of the hull
// The outlines of all photos vote for a second hull, which gives the masks. A polygon is exact in its own photo. Glass reflects:
// pixels marked transparent are specular, too.
#pragma once

#include <functional>
#include <memory>

#include "stages/masks/boxes/carried_object.h"

namespace vitrine {

struct MarkedMasks {
  std::vector<CarriedObject::Summary> objects;
  std::vector<Intrinsics> sizes;                                           // [view]
  std::vector<std::array<std::vector<uint8_t>, kMaskClassCount>> inside;   // [view][class][h,w]
  std::vector<std::array<std::vector<uint8_t>, kMaskClassCount>> doubted;  // outline and hull disagree
  std::vector<std::vector<uint16_t>> shown;                                // [view][h,w] 1 + index of the nearest object; 0: none
};
// Throws Error{Input} when the cones of the marks of an object have no common point.
std::shared_ptr<const MarkedMasks> carry_marks(const MaskCapture& capture, const std::vector<MarkedObject>& objects,
                                               int hull_voxels, const std::function<void(double)>& progress);

class MarkedSource final : public MaskSource {
 public:
  MarkedSource(std::shared_ptr<const MarkedMasks> masks, MaskClass kind) : masks_(std::move(masks)), kind_(kind) {}
  std::string_view name() const override { return "boxes"; }
  std::optional<SoftMask> at(size_t view) const override;
  std::string_view trust() const override { return "marked"; }
  bool propagated() const override { return true; }
  void report(nlohmann::ordered_json& j) const override;

 private:
  std::shared_ptr<const MarkedMasks> masks_;
  MaskClass kind_;
};

// Writes masks/marked when an object has a name (core/scene/camera/view_masks.h).
void write_marked_objects(const std::filesystem::path& artifact, const MaskCapture& capture, const MarkedMasks& masks);

// True if marks of class `kind` also mark class `of`.
bool marks_class(MaskClass kind, MaskClass of);

}  // namespace vitrine
