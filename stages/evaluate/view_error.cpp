#include "stages/evaluate/view_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/vec.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/metrics.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

// `k`, limited to `width` pixels.
Intrinsics no_finer(const Intrinsics& k, int width) {
  if (width >= k.width) return k;
  return k.scaled_to(width, std::max(1, int(std::lround(double(k.height) * width / k.width))));
}

float encoded(double linear) { return srgb_from_linear(float(std::clamp(linear, 0.0, 1.0))); }

// sRGB values of a photo.
constexpr float kBright = 0.5f;
constexpr float kNeutral = 0.03f;  // difference of two channels of a pixel: 5 to 7 % in linear light
constexpr float kPlain = 0.04f;    // difference of two pixels in the neighbourhood, in any channel: noise and JPEG, no texture
constexpr int kRadius = 2;         // of the neighbourhood
constexpr double kBlack = 1e-3;    // lower bound of a render in linear light: keeps its logarithm finite

bool plain_and_neutral(const ImageF& photo, const ImageF& counts, int x, int y) {
  const float* middle = photo.pixel(x, y);
  const auto [least, most] = std::minmax({middle[0], middle[1], middle[2]});
  if (least < kBright || most - least > kNeutral) return false;
  float low[3] = {1, 1, 1}, high[3] = {0, 0, 0};
  for (int v = y - kRadius; v <= y + kRadius; ++v) {
    for (int u = x - kRadius; u <= x + kRadius; ++u) {
      if (counts.at(u, v) == 0) return false;
      for (int c = 0; c < 3; ++c) {
        low[c] = std::min(low[c], photo.at(u, v, c));
        high[c] = std::max(high[c], photo.at(u, v, c));
        if (high[c] - low[c] > kPlain) return false;
      }
    }
  }
  return true;
}

}  // namespace

double mean(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (double v : values) sum += v;
  return sum / double(values.size());
}

void add_surface_error(const ViewPicture& ours, const SurfaceTruth& truth, const Similarity& truth_from_ours, const ImageF* mask,
                       SurfaceError& sum) {
  const auto normal_of = [](const ImageF& image, size_t i) {
    const float* n = image.data().data() + 3 * i;
    return Vec3d{n[0], n[1], n[2]};
  };
  for (size_t i = 0; i < ours.zdepth.pixel_count(); ++i) {
    const double z = ours.zdepth.data()[i];
    if (!(z > 0) || (mask != nullptr && !(mask->data()[i] > 0))) continue;
    if (!truth.zdepth.empty() && truth.zdepth.data()[i] > 0) {
      const double zt = truth.zdepth.data()[i];
      sum.zdepth_rel.push_back(std::abs(truth_from_ours.scale * z - zt) / zt);
    }
    if (truth.normal.empty()) continue;
    const Vec3d a = normal_of(ours.normal_in_world, i), b = normal_of(truth.normal, i);
    if (squared_length(a) == 0 || squared_length(b) == 0) continue;
    const Vec3d turned = truth_from_ours.rotation * a;
    const double angle = std::atan2(length(cross(turned, b)), dot(turned, b)) * 180 / std::numbers::pi;
    sum.normal_deg.push_back(angle);
  }
}

std::optional<double> radiance_psnr(const RadiancePicture& ours, const TruthPicture& truth, int min_pixels) {
  const Intrinsics k = no_finer(ours.intrinsics, truth.intrinsics.width), from = no_finer(truth.intrinsics, k.width);
  const ImageF map = at_size(truth.radiance, from), mask = at_size(ours.mask, k);
  ImageF picture = at_size(ours.radiance, k), expected(k.width, k.height, 3), counts(k.width, k.height, 1);
  int count = 0;
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = encoded(ours.gain[size_t(c)] * picture.at(x, y, c));
      const auto at = image_point(truth.truth_from_ours * k.ray(x + 0.5, y + 0.5), from);
      if (!(mask.at(x, y) > 0.5f) || !at) continue;
      float radiance[3];
      sample_bilinear(map, at->x, at->y, radiance);
      for (int c = 0; c < 3; ++c) expected.at(x, y, c) = encoded(radiance[c]);
      counts.at(x, y) = 1;
      ++count;
    }
  if (count < min_pixels) return std::nullopt;
  return psnr(picture, expected, &counts);
}

std::optional<double> neutral_shift(const ImageF& srgb, const ImageF& photo, const ImageF& counts, int min_pixels) {
  VITRINE_CHECK(srgb.width() == photo.width() && srgb.height() == photo.height() && counts.width() == photo.width() &&
                    counts.height() == photo.height(),
                "pictures of different size");
  std::vector<double> log_ratio[3];
  for (int y = kRadius; y < photo.height() - kRadius; ++y)
    for (int x = kRadius; x < photo.width() - kRadius; ++x) {
      if (!plain_and_neutral(photo, counts, x, y)) continue;
      for (int c = 0; c < 3; ++c) {
        const double render = linear_from_srgb(static_cast<double>(srgb.at(x, y, c)));
        log_ratio[c].push_back(std::log(std::max(render, kBlack) / linear_from_srgb(static_cast<double>(photo.at(x, y, c)))));
      }
    }
  if (log_ratio[0].empty() || log_ratio[0].size() < static_cast<size_t>(std::max(min_pixels, 0))) return std::nullopt;
  double median[3];
  for (int c = 0; c < 3; ++c) median[c] = upper_median(std::move(log_ratio[c]));
  const auto [least, most] = std::minmax({median[0], median[1], median[2]});
  return std::exp(most - least) - 1;
}

void add_confidence_samples(const ImageF& confidence, const ImageF& error, const ImageF& counts, ConfidenceSamples& samples) {
  constexpr size_t kMostPixels = 65536;
  const size_t n = counts.pixel_count(), step = std::max<size_t>(1, (n + kMostPixels - 1) / kMostPixels);
  for (size_t i = 0; i < n; i += step)
    if (counts.data()[i] > 0) samples.confidence.push_back(confidence.data()[i]), samples.error.push_back(error.data()[i]);
}

std::optional<double> rank_correlation(std::span<const float> a, std::span<const float> b) {
  VITRINE_CHECK(a.size() == b.size(), "{} values and {}", a.size(), b.size());
  const auto ranks = [](std::span<const float> values) {
    std::vector<size_t> order(values.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](size_t i, size_t j) { return values[i] < values[j]; });
    std::vector<double> out(values.size());
    for (size_t first = 0, last = 0; first < order.size(); first = last) {
      while (last < order.size() && values[order[last]] == values[order[first]]) ++last;
      for (size_t k = first; k < last; ++k) out[order[k]] = 0.5 * double(first + last - 1);
    }
    return out;
  };
  const std::vector<double> x = ranks(a), y = ranks(b);
  const double centre = 0.5 * (double(a.size()) - 1);  // the mean rank of both
  double xy = 0, xx = 0, yy = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - centre) * (y[i] - centre);
    xx += (x[i] - centre) * (x[i] - centre), yy += (y[i] - centre) * (y[i] - centre);
  }
  return xx > 0 && yy > 0 ? std::optional(xy / std::sqrt(xx * yy)) : std::nullopt;
}

std::optional<ConfidenceScore> confidence_against_error(const ConfidenceSamples& samples) {
  const auto correlation = rank_correlation(samples.confidence, samples.error);
  if (!correlation) return std::nullopt;
  double sum = 0;
  for (const float c : samples.confidence) sum += c;
  return ConfidenceScore{sum / double(samples.confidence.size()), -*correlation, samples.confidence.size()};
}

}  // namespace vitrine
