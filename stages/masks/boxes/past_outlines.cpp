#include "stages/masks/boxes/past_outlines.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/base/process.h"
#include "core/stereo/stereo_photos.h"
#include "stages/masks/boxes/outline_cut.h"

namespace vitrine {

namespace {

constexpr size_t kStereoNeighbours = 5;
constexpr int kStereoRounds = 2;  // four find no better background
constexpr double kFarFactor = 2;
constexpr uint64_t kSeed = 1;
constexpr double kLeastReliable = 0.05;  // of all pixels

}  // namespace

PastOutlines::PastOutlines(std::span<const SmallPhoto> photos, const MaskCapture& capture) {
  for (const SmallPhoto& small : photos) views_.push_back(small.view), photos_.push_back(edge_photo(small));
  std::vector<uint32_t> all(photos_.size());
  for (uint32_t v = 0; v < all.size(); ++v) all[v] = v;
  std::vector<std::vector<uint32_t>> neighbours = stereo_neighbours(capture.set, all, kStereoNeighbours);
  std::vector<StereoPhoto> stereo(photos_.size());
  for (size_t v = 0; v < stereo.size(); ++v) {
    stereo[v].view = views_[v];
    stereo[v].luma = luma_of_srgb(photos_[v].srgb);
    stereo[v].neighbours = std::move(neighbours[v]);
  }
  find_depth_ranges(capture.set, kFarFactor, stereo);
  maps_ = patch_match(stereo, {.iterations = kStereoRounds, .seed = kSeed});
  throw_if_interrupted();
  count_agreement(stereo, maps_);
  planes_ = scene_planes(stereo, maps_);
}

bool PastOutlines::blind() const {
  size_t reliable = 0, pixels = 0;
  for (const DepthMap& map : maps_) pixels += map.trusted.size(), reliable += size_t(std::ranges::count(map.trusted, 1));
  return double(reliable) < kLeastReliable * double(pixels) || pixels == 0;
}

std::vector<HalfSpace> PastOutlines::sides(const VisualHull& hull) const {
  return sides_of_cameras(planes_, views_, hull.bounds());
}

std::vector<std::vector<uint8_t>> PastOutlines::hidden(const VisualHull& around) const {
  std::vector<std::vector<uint8_t>> hidden(views_.size());
  parallel_for(views_.size(), 1, [&](size_t v) { hidden[v] = hidden_pixels(maps_[v], hull_depths(around, views_[v])); });
  return hidden;
}

std::vector<Silhouette> PastOutlines::outlines(const VisualHull& hull, std::span<const std::vector<uint8_t>> hidden) const {
  const std::vector<std::vector<uint8_t>> about = silhouettes_of(hull, views_);
  std::vector<HullDepths> passed(views_.size());
  parallel_for(views_.size(), 1, [&](size_t v) { passed[v] = hull_depths(hull, views_[v]); });
  const Surroundings scene{.photos = photos_, .maps = maps_, .planes = planes_};
  std::vector<Silhouette> found(views_.size());
  parallel_for(views_.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    found[v] = silhouette(views_[v], outline_cut(photos_[v], unexplained(scene, hull, passed, v), about[v]));
    for (size_t i = 0; i < hidden[v].size(); ++i)
      if (hidden[v][i]) found[v].value.data()[i] = -1;
  });
  throw_if_interrupted();
  return found;
}

}  // namespace vitrine
