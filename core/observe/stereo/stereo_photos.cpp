#include "core/observe/stereo/stereo_photos.h"

#include <algorithm>

#include "core/scene/camera/projection.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {

namespace {

constexpr double kNearShare = 0.6;  // near plane, as a factor of the nearest sparse point's depth
constexpr double kFarPercentile = 0.98;
// Depth range without any sparse point: this factor around the camera radius, which is 1 in the scene frame.
constexpr double kBlindDepthFactor = 4;

}  // namespace

ImageF luma_of_srgb(const ImageF& srgb) {
  ImageF grey(srgb.width(), srgb.height(), 1);
  for (size_t i = 0; i < grey.data().size(); ++i) {
    const float* p = srgb.data().data() + 3 * i;
    grey.data()[i] = 0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2];
  }
  return grey;
}

void find_depth_ranges(const ViewSet& set, double far_factor, std::span<StereoPhoto> photos) {
  for (const ScenePoint& point : set.points)
    for (uint32_t v : point.views) {
      if (photos[v].luma.empty()) continue;
      if (const auto p = projection(point.position, photos[v].view)) photos[v].hints.push_back({p->x, p->y, p->z});
    }
  for (StereoPhoto& photo : photos) {
    photo.near_z = 1 / kBlindDepthFactor, photo.far_z = kBlindDepthFactor;
    if (photo.hints.empty()) continue;
    std::vector<double> depths;
    for (const Vec3d& h : photo.hints) depths.push_back(h.z);
    photo.near_z = kNearShare * std::ranges::min(depths);
    photo.far_z = far_factor * quantile_of(depths, kFarPercentile);
  }
}

}  // namespace vitrine
