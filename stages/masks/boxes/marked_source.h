// Masks from a few marks of the user's. A mark cuts a cone out of space; where the cones of all marked photos meet is the thing's
// visual hull, and the hull is seen by every camera:
//   glass    its outline in the other photos is the hull's
//   mirrors  in boxes have no colour of their own: photos tell what is seen past the hull (outlines.h)
//   others   GrabCut (Rother et al. 2004) looks for the outline near the hull's
// A second hull lets the outlines of all photos vote and gives the masks.
// A polygon is believed where it was drawn. Glass mirrors: what is marked transparent is specular, too.
#pragma once

#include <functional>
#include <memory>

#include "stages/masks/boxes/carried_thing.h"

namespace vitrine {

struct MarkedMasks {
  std::vector<CarriedThing::Summary> things;
  std::vector<Intrinsics> sizes;                                           // [view]
  std::vector<std::array<std::vector<uint8_t>, kMaskClassCount>> inside;   // [view][class][h,w]
  std::vector<std::array<std::vector<uint8_t>, kMaskClassCount>> doubted;  // outline and hull disagree
  std::vector<std::vector<uint16_t>> shown;                                // [view][h,w] 1 + the nearest thing; 0: none
};
// Throws Error{Input} when no point of space lies inside all marks of a thing.
std::shared_ptr<const MarkedMasks> carry_marks(const MaskCapture& capture, const std::vector<MarkedThing>& things,
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

// masks/marked, where a thing has a name (core/scene/camera/view_masks.h).
void write_marked_things(const std::filesystem::path& artifact, const MaskCapture& capture, const MarkedMasks& masks);

// Whether marks of `kind` say something of `of`.
bool marks_class(MaskClass kind, MaskClass of);

}  // namespace vitrine
