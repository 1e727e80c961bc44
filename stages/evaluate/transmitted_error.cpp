#include "stages/evaluate/transmitted_error.h"

#include <algorithm>
#include <cmath>

#include "core/camera/projection.h"
#include "core/image/metrics.h"
#include "core/image/resample.h"
#include "core/math/color.h"

namespace vitrine {

namespace {

// As `k`, but no finer than `width` pixels across.
Intrinsics no_finer(const Intrinsics& k, int width) {
  if (width >= k.width) return k;
  return k.scaled_to(width, std::max(1, int(std::lround(double(k.height) * width / k.width))));
}

float encoded(double linear) { return srgb_from_linear(float(std::clamp(linear, 0.0, 1.0))); }

}  // namespace

std::optional<double> transmitted_psnr(const TransmittedPicture& ours, const TruthPicture& truth, int min_pixels) {
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

}  // namespace vitrine
