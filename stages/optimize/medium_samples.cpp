#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/camera/projection.h"
#include "stages/optimize/medium_fit.h"

namespace vitrine {

namespace {

constexpr uint64_t kMediumStream = 0x1903;
constexpr size_t kStereoPoints = 3000, kSparsePoints = 1000;
constexpr size_t kFewestSamples = 3;      // of a point
constexpr double kSameDepth_rel = 0.015;  // relative difference of depth
constexpr float kLeastSpread = 1.1f;      // farthest over nearest distance of a point
// Side of the square of which a colour is the mean, pixels, in the farthest photo of the point. In nearer photos the square, the
// pixel of the sensor and that of the interpolation have together the same variance on the surface. Otherwise detail that blurs
// with the distance would look like haze.
constexpr double kFarthestSide = 3;
constexpr double kSampleBorder = 1;        // pixels
constexpr float kDarkRange = 1.1f;         // farthest over nearest distance of a range
constexpr size_t kFewestDarkPixels = 200;  // of a range of distances
constexpr double kDarkShare = 0.01;        // of its pixels

// Photos at the size of the depth maps.
class MediumPixels {
 public:
  MediumPixels(const Capture& capture, const Targets& targets, const DenseDepth& dense)
      : capture_(capture), targets_(targets), dense_(dense) {}

  const PhotoLevel& level(uint32_t photo) const { return capture_.photos[photo].levels[dense_.level]; }
  // Neither glass nor mirror nor ignored.
  bool matte(uint32_t photo, size_t pixel) const {
    const TargetLevel& target = targets_.photos[photo][dense_.level];
    for (const MaskClass mask : {MaskClass::Specular, MaskClass::Transparent, MaskClass::Ignore})
      if (const auto& m = target.masks[size_t(mask)]; !m.empty() && m[pixel] > 0) return false;
    return target.coat.empty() || target.coat[pixel] == 0;
  }
  // The photo's sample of `point`, without its colour; nullopt: outside, clipped, glass, mirrors, ignored.
  std::optional<MediumSample> at(uint32_t photo, const Vec3d& point) const {
    const PhotoLevel& seen = level(photo);
    const auto q = image_point(point, seen.view, 0, kSampleBorder);
    if (!q) return std::nullopt;
    const size_t pixel = seen.view.intrinsics.index(int(q->x), int(q->y)), pixels = seen.view.intrinsics.pixel_count();
    if (!matte(photo, pixel)) return std::nullopt;
    for (size_t c = 0; c < 3; ++c)
      if (float(seen.srgb[c * pixels + pixel]) >= kClippedSrgb * 65535.f) return std::nullopt;
    return MediumSample{
        .point = 0, .photo = photo, .distance = static_cast<float>(length(point - seen.view.centre_in_world())), .linear = {}};
  }
  // Sets the colours of one point's samples.
  void fill(const Vec3d& point, std::vector<MediumSample>& samples) const {
    float farthest = 0;
    for (const MediumSample& s : samples) farthest = std::max(farthest, s.distance);
    for (MediumSample& s : samples) {
      const double ratio = double(farthest / s.distance);
      const double side = std::sqrt((kFarthestSide * kFarthestSide + 2) * ratio * ratio - 2);
      s.linear = mean_around(level(s.photo), *image_point(point, level(s.photo).view), side);
    }
  }
  // Whether the depth map of the photo has the surface of `point`.
  bool shows(uint32_t photo, const Vec3d& point) const {
    const DepthMap& map = dense_.maps[photo];
    if (map.zdepth.empty()) return false;
    const auto q = image_point(point, dense_.photos[photo].view);
    if (!q) return false;
    const size_t pixel = map.index(int(q->x), int(q->y));
    return map.reliable(pixel) && std::abs(double(map.zdepth[pixel]) - q->z) < kSameDepth_rel * q->z;
  }

 private:
  // Mean over the square of this side, cut at the border of the photo.
  static Vec3f mean_around(const PhotoLevel& level, const ImagePoint& at, double side) {
    const Intrinsics& k = level.view.intrinsics;
    const auto covered = [&](int pixel, double middle) {
      return std::clamp(std::min(pixel + 1.0, middle + 0.5 * side) - std::max(double(pixel), middle - 0.5 * side), 0.0, 1.0);
    };
    Vec3d sum{};
    double weights = 0;
    for (int y = std::max(0, int(at.y - 0.5 * side)); y <= std::min(k.height - 1, int(at.y + 0.5 * side)); ++y)
      for (int x = std::max(0, int(at.x - 0.5 * side)); x <= std::min(k.width - 1, int(at.x + 0.5 * side)); ++x) {
        const double weight = covered(x, at.x) * covered(y, at.y);
        sum += weight * cast<double>(linear_at(level, k.index(x, y)));
        weights += weight;
      }
    return cast<float>(sum / weights);
  }

  const Capture& capture_;
  const Targets& targets_;
  const DenseDepth& dense_;
};

bool informative(std::span<const MediumSample> samples) {
  if (samples.size() < kFewestSamples) return false;
  const auto [nearest, farthest] = std::ranges::minmax_element(samples, {}, &MediumSample::distance);
  return farthest->distance > kLeastSpread * nearest->distance;
}

}  // namespace

std::vector<MediumSample> medium_samples(const Capture& capture, const Targets& targets, const DenseDepth& dense, uint64_t seed) {
  const MediumPixels samples(capture, targets, dense);
  const std::vector<uint32_t>& photos = capture.train;
  std::vector<std::vector<MediumSample>> found(kStereoPoints + kSparsePoints);
  parallel_for(found.size(), 64, [&](size_t i) {
    Rng rng(seed, mix64(kMediumStream, i));
    if (i >= kStereoPoints) {
      const std::vector<ScenePoint>& points = capture.view_set.points;
      const size_t count = std::min(points.size(), kSparsePoints), number = i - kStereoPoints;
      if (number >= count) return;
      const ScenePoint& point = points[number * points.size() / count];
      for (const uint32_t photo : point.views)
        if (std::ranges::binary_search(photos, photo))
          if (const auto sample = samples.at(photo, point.position)) found[i].push_back(*sample);
      samples.fill(point.position, found[i]);
    } else {
      const uint32_t from = photos[rng.below(static_cast<uint32_t>(photos.size()))];
      const DepthMap& map = dense.maps[from];
      if (map.zdepth.empty()) return;
      const int x = int(rng.below(uint32_t(map.width))), y = int(rng.below(uint32_t(map.height)));
      const size_t pixel = map.index(x, y);
      if (!map.reliable(pixel) || double(map.zdepth[pixel]) > 0.5 * dense.background) return;
      const View& view = dense.photos[from].view;
      const Vec3d point = inverse(view.cam_from_world) * (double(map.zdepth[pixel]) * view.intrinsics.ray(x + 0.5, y + 0.5));
      for (const uint32_t photo : photos)
        if (photo == from || samples.shows(photo, point))
          if (const auto sample = samples.at(photo, point)) found[i].push_back(*sample);
      samples.fill(point, found[i]);
    }
    if (!informative(found[i])) found[i].clear();
    for (MediumSample& s : found[i]) s.point = static_cast<uint32_t>(i);
  });
  std::vector<MediumSample> all;
  for (const auto& of_point : found) all.insert(all.end(), of_point.begin(), of_point.end());
  return all;
}

std::vector<DarkLevel> dark_levels(const Capture& capture, const Targets& targets, const DenseDepth& dense) {
  struct Seen {
    float distance;
    Vec3f linear;
  };
  const MediumPixels pixels(capture, targets, dense);
  std::vector<Seen> all;
  for (const uint32_t photo : capture.train) {
    const DepthMap& map = dense.maps[photo];
    const PhotoLevel& level = pixels.level(photo);
    const Intrinsics& k = level.view.intrinsics;
    for (size_t i = 0; i < map.zdepth.size(); ++i) {
      if (!map.reliable(i) || double(map.zdepth[i]) > 0.5 * dense.background || !pixels.matte(photo, i)) continue;
      const auto width = static_cast<size_t>(k.width);
      const double ray = length(k.ray(double(i % width) + 0.5, double(i / width) + 0.5));
      all.push_back({float(ray * double(map.zdepth[i])), linear_at(level, i)});
    }
  }
  std::ranges::sort(all, {}, &Seen::distance);
  std::vector<DarkLevel> levels;
  for (auto from = all.begin(); from != all.end();) {
    const auto to = std::ranges::upper_bound(from, all.end(), kDarkRange * from->distance, {}, &Seen::distance);
    const auto limit = from + static_cast<std::ptrdiff_t>(kDarkShare * double(to - from));
    DarkLevel level{};
    for (size_t c = 0; c < 3 && size_t(to - from) >= kFewestDarkPixels; ++c) {
      std::ranges::nth_element(from, limit, to, {}, [c](const Seen& s) { return s.linear[c]; });
      level.distance[c] = double(limit->distance), level.linear[c] = double(limit->linear[c]);
    }
    if (size_t(to - from) >= kFewestDarkPixels) levels.push_back(level);
    from = to;
  }
  return levels;
}

}  // namespace vitrine
