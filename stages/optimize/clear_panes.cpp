#include "stages/optimize/layer_init.h"

#include <algorithm>

#include "core/foundation/base/log.h"

namespace vitrine {

namespace {

constexpr double kAtFace_rel = 0.25;  // of the longest side, along the ray: content farther behind the face is seen through it
constexpr double kTelling_rel = 0.2;  // of the pixel count of the most used exit face: faces with fewer pixels are not classified

}  // namespace

ShapeSet::Entry with_clear_panes(ShapeSet::Entry sheet, const Capture& capture, const Targets& targets,
                                 std::span<const std::vector<float>> depths, size_t level) {
  const auto* found = std::get_if<Box>(&sheet.shape);
  if (!found || !sheet.clear.empty()) return sheet;
  const Box& box = *found;
  std::array<size_t, Box::kFaces> left{}, beyond{};
  const double at_face = kAtFace_rel * box.longest_side();
  for (const uint32_t photo : capture.train) {
    const auto& mask = targets.photos[photo][level].masks[size_t(MaskClass::Transparent)];
    const View& view = capture.photos[photo].levels[level].view;
    const Vec3d eye = view.centre_in_world();
    for (size_t i = 0; i < mask.size(); ++i) {
      if (mask[i] < 128) continue;
      const auto width = static_cast<size_t>(view.intrinsics.width);
      const Vec3d per_z = view.ray(double(i % width) + 0.5, double(i / width) + 0.5);
      const auto crossing = box.crossing(eye, per_z);
      if (!crossing) continue;
      const size_t face = crossing->left.index();
      const double z = double(depths[photo][i]), inside = (crossing->out - z) * length(per_z);
      if (z > 0 && inside > at_face) continue;  // the content is inside the case
      ++left[face];
      beyond[face] += z == 0 || inside < -at_face;
    }
  }
  sheet.clear.assign(Box::kFaces, 0);
  size_t panes = 0;
  const double telling = kTelling_rel * double(*std::ranges::max_element(left));
  for (size_t f = 0; f < Box::kFaces; ++f) {
    sheet.clear[f] = double(left[f]) < telling || 2 * beyond[f] >= left[f];
    panes += sheet.clear[f];
  }
  log_info("{} of the box's faces are clear panes", panes);
  return sheet;
}

}  // namespace vitrine
