#include "stages/optimize/object_alone.h"

namespace vitrine {

namespace {

constexpr double kMostOutside = 0.1, kMostDissent = 0.1;

enum class Seen : unsigned char { Not, Inside, Outside };

Seen seen(const Capture& capture, const Targets& targets, size_t photo, const Vec3d& position) {
  const auto& mask = targets.photos[photo][0].masks[static_cast<size_t>(MaskClass::Object)];
  if (mask.empty()) return Seen::Not;
  const View& view = capture.photos[photo].levels[0].view;
  const Intrinsics& k = view.intrinsics;
  const Vec3d p = view.cam_from_world * position;
  if (!(p.z > 0)) return Seen::Not;
  const double x = k.fx * p.x / p.z + k.cx, y = k.fy * p.y / p.z + k.cy;
  if (!(x >= 0 && y >= 0 && x < k.width && y < k.height)) return Seen::Not;
  return mask[size_t(y) * size_t(k.width) + size_t(x)] >= 128 ? Seen::Inside : Seen::Outside;
}

}  // namespace

double sightings_outside_object(const Capture& capture, const Targets& targets) {
  size_t all = 0, outside = 0;
  for (const ScenePoint& point : capture.view_set.points)
    for (uint32_t photo : point.views) {
      const Seen how = seen(capture, targets, photo, point.position);
      all += how != Seen::Not;
      outside += how == Seen::Outside;
    }
  return all > 0 ? double(outside) / double(all) : 1;
}

bool object_alone(const std::string& wanted, const Capture& capture, const Targets& targets) {
  if (wanted == "train" || !targets.any(MaskClass::Object)) return false;
  if (wanted == "ignore") return true;
  return targets.vouched(MaskClass::Object) && sightings_outside_object(capture, targets) < kMostOutside;
}

bool on_object(const Capture& capture, const Targets& targets, const Vec3d& position) {
  size_t all = 0, outside = 0;
  for (uint32_t photo : capture.train) {
    const Seen how = seen(capture, targets, photo, position);
    all += how != Seen::Not;
    outside += how == Seen::Outside;
  }
  return double(outside) <= kMostDissent * double(all);
}

}  // namespace vitrine
