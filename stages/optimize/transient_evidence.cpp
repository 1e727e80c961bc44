#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/median.h"
#include "core/scene/camera/projection.h"
#include "stages/optimize/transients.h"

namespace vitrine {

namespace {

constexpr size_t kFewestOthers = 3;    // photos that see the same surface point
constexpr double kSameSurface = 0.03;  // relative depth
constexpr float kNoticed = 0.035f;     // smaller residuals are not compared with other photos
constexpr int kColourReach = 2;        // pixels around a noticed one whose colour the other photos must give
constexpr double kInsideBorder = 1;    // pixels

template <class F>
void around(const Intrinsics& k, int x, int y, int reach, const F& visit) {
  for (int v = std::max(0, y - reach); v <= std::min(k.height - 1, y + reach); ++v)
    for (int u = std::max(0, x - reach); u <= std::min(k.width - 1, x + reach); ++u) visit(k.index(u, v));
}

// Distance of each pixel from the range of `picture` in its 3x3 pixels: a shift by a pixel is no difference. A clipped channel is
// a lower bound.
std::vector<float> range_error(const Intrinsics& k, std::span<const float> photo, std::span<const float> picture) {
  const size_t n = k.pixel_count();
  std::vector<float> error(n, 0.f);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x)
      for (size_t c = 0; c < 3; ++c) {
        float least = 1e9f, most = -1e9f;
        around(k, x, y, 1,
               [&](size_t i) { least = std::min(least, picture[c * n + i]), most = std::max(most, picture[c * n + i]); });
        const float value = photo[c * n + k.index(x, y)];
        const float above = value >= kClippedSrgb ? 0.f : least - value;
        error[k.index(x, y)] += std::max({0.f, above, value - most}) / 3;
      }
  return error;
}

std::vector<float> mean_3x3(const Intrinsics& k, std::span<const float> values) {
  std::vector<float> mean(values.size());
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      float sum = 0, count = 0;
      around(k, x, y, 1, [&](size_t i) { sum += values[i], ++count; });
      mean[k.index(x, y)] = sum / count;
    }
  return mean;
}

std::vector<uint8_t> noticed(const Intrinsics& k, std::span<const float> residual) {
  std::vector<uint8_t> wanted(residual.size(), 0);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x)
      if (residual[k.index(x, y)] > kNoticed) around(k, x, y, kColourReach, [&](size_t i) { wanted[i] = 1; });
  return wanted;
}

float same_exposure(float srgb, float from, float to) {
  return srgb_from_linear(std::min(1.f, linear_from_srgb(srgb) / from * to));
}

// What the other photos show at the surface points of one photo.
class OtherPhotos {
 public:
  OtherPhotos(std::span<const TransientPhoto> photos, std::span<const std::vector<float>> residuals, size_t own)
      : photos_(photos), residuals_(residuals), own_(own) {}

  // False: too few see the point.
  bool compare(int x, int y) {
    const View& view = photos_[own_].view;
    const float z = photos_[own_].zdepth[view.intrinsics.index(x, y)];
    residual_.clear();
    for (std::vector<float>& values : colour_) values.clear();
    if (!(z > 0)) return false;
    const Vec3d at = inverse(view.cam_from_world) * (double(z) * view.intrinsics.ray(x + 0.5, y + 0.5));
    for (size_t other = 0; other < photos_.size(); ++other)
      if (other != own_) add(other, at);
    return residual_.size() >= kFewestOthers;
  }
  float residual() { return upper_median_of(std::span<float>(residual_)); }
  float colour(size_t c) { return upper_median_of(std::span<float>(colour_[c])); }

 private:
  void add(size_t other, const Vec3d& at) {
    const TransientPhoto& photo = photos_[other];
    const auto p = image_point(at, photo.view, 0, kInsideBorder);
    if (!p) return;
    const size_t i = photo.view.intrinsics.index(int(p->x), int(p->y)), n = photo.zdepth.size();
    if (!(photo.zdepth[i] > 0) || std::abs(double(photo.zdepth[i]) - p->z) > kSameSurface * p->z) return;
    residual_.push_back(residuals_[other][i]);
    for (size_t c = 0; c < 3; ++c)
      colour_[c].push_back(same_exposure(photo.photo[c * n + i], photo.view.gain[c], photos_[own_].view.gain[c]));
  }

  std::span<const TransientPhoto> photos_;
  std::span<const std::vector<float>> residuals_;
  size_t own_;
  std::vector<float> residual_;
  std::array<std::vector<float>, 3> colour_;
};

TransientEvidence evidence_of(std::span<const TransientPhoto> photos, std::span<const std::vector<float>> residuals, size_t own) {
  const TransientPhoto& photo = photos[own];
  const Intrinsics& k = photo.view.intrinsics;
  const size_t n = k.pixel_count();
  const std::vector<uint8_t> wanted = noticed(k, residuals[own]);
  TransientEvidence evidence{std::vector<float>(n, 0.f), std::vector<float>(n, 1.f)};
  std::vector<float> others = photo.photo;
  std::vector<uint8_t> seen(n, 0);
  OtherPhotos others_at(photos, residuals, own);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t i = k.index(x, y);
      if (!wanted[i] || !others_at.compare(x, y)) continue;
      seen[i] = 1;
      evidence.elsewhere[i] = others_at.residual();
      for (size_t c = 0; c < 3; ++c) others[c * n + i] = others_at.colour(c);
    }
  const std::vector<float> against = mean_3x3(k, range_error(k, photo.photo, others));
  for (size_t i = 0; i < n; ++i)
    if (seen[i]) evidence.residual[i] = std::min(residuals[own][i], against[i]);
  return evidence;
}

}  // namespace

std::vector<TransientEvidence> transient_evidence(std::span<const TransientPhoto> photos) {
  std::vector<std::vector<float>> residuals(photos.size());
  parallel_for(photos.size(), 1, [&](size_t v) {
    const Intrinsics& k = photos[v].view.intrinsics;
    residuals[v] = mean_3x3(k, range_error(k, photos[v].photo, photos[v].picture));
  });
  std::vector<TransientEvidence> evidence(photos.size());
  parallel_for(photos.size(), 1, [&](size_t v) {
    throw_if_interrupted();
    evidence[v] = evidence_of(photos, residuals, v);
  });
  return evidence;
}

}  // namespace vitrine
