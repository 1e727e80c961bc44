#include "core/observe/stereo/small_stereo.h"

#include <algorithm>

#include "core/foundation/base/process.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

constexpr size_t kStereoNeighbours = 5;
constexpr int kStereoRounds = 2;  // four give no better background
constexpr double kFarFactor = 2;
constexpr uint64_t kSeed = 1;
constexpr double kLeastReliable = 0.05;  // of all pixels

}  // namespace

SmallStereo::SmallStereo(std::vector<EdgePhoto> photos, const ViewSet& set) : photos_(std::move(photos)) {
  for (const EdgePhoto& photo : photos_) views_.push_back(photo.view);
  std::vector<uint32_t> all;
  for (uint32_t v = 0; v < photos_.size(); ++v)
    if (!photos_[v].srgb.empty()) all.push_back(v);
  std::vector<std::vector<uint32_t>> neighbours = stereo_neighbours(set, all, kStereoNeighbours);
  std::vector<StereoPhoto> stereo(photos_.size());
  for (size_t v = 0; v < stereo.size(); ++v) {
    stereo[v].view = views_[v];
    if (!photos_[v].srgb.empty()) stereo[v].luma = luma_of_srgb(photos_[v].srgb);
    stereo[v].neighbours = std::move(neighbours[v]);
  }
  find_depth_ranges(set, kFarFactor, stereo);
  maps_ = patch_match(stereo, {.iterations = kStereoRounds, .seed = kSeed});
  throw_if_interrupted();
  count_agreement(stereo, maps_);
  planes_ = scene_planes(stereo, maps_);
}

bool SmallStereo::blind() const {
  size_t reliable = 0, pixels = 0;
  for (const DepthMap& map : maps_) pixels += map.trusted.size(), reliable += size_t(std::ranges::count(map.trusted, 1));
  return double(reliable) < kLeastReliable * double(pixels) || pixels == 0;
}

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
