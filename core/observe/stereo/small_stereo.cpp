#include "core/observe/stereo/small_stereo.h"

#include <algorithm>

#include "core/foundation/base/process.h"
#include "core/observe/stereo/stereo_photos.h"

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

}  // namespace vitrine
