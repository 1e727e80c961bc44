// The shape of polished metal. What surfels learn there are pictures in the mirror, at their depths and with their normals; what
// photos tell of the metal itself is its outline. Where the masks stage marks mirrors that are not glass, the fused depth is that
// of the visual hull of their outlines (core/stereo/visual_hull); photos in which something dull stands in front, or glass, say
// nothing there.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/stereo/visual_hull.h"
#include "stages/mesh/rgbd_frame.h"

namespace vitrine {

class MirrorShape {
 public:
  // `masks`: artifact of the masks stage. `photos`: views at full size; `views`: those that are fused; `frame_of`: their depth.
  MirrorShape(const std::filesystem::path& masks, const std::vector<View>& photos, const std::vector<View>& views,
              const std::function<RgbdFrame(size_t)>& frame_of);

  bool empty() const { return !hull_ || hull_->empty(); }  // nothing is marked, or the outlines do not close
  const Bounds3& bounds() const { return hull_->bounds(); }

  // Puts the hull's depth where view i marks mirrors, but where the frame knows a surface more than `tolerance` in front of it.
  // Marked pixels beside the hull are not fused.
  void put(size_t i, RgbdFrame& frame, double tolerance) const;

 private:
  std::vector<ImageF> marks_;  // [view] at most kMaskSide large: 1 mirror, 0 not, -1 glass; empty: unmarked
  std::optional<VisualHull> hull_;
};

}  // namespace vitrine
