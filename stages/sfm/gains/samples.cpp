#include <cmath>

#include "core/base/parallel.h"
#include "stages/sfm/gains/gains.h"

namespace vitrine {

namespace {

// Five pixels: features sit on blobs of this size and larger, and a pose error of half a pixel moves little of the square.
constexpr int kRadius = 2;
// Of full scale, in linear light: code 249 of 255. Resampling takes a clipped pixel down a little.
constexpr float kClipped = 0.95f;

}  // namespace

bool sample_colour(const ImageF& linear, double x, double y, int radius, Vec3f& colour) {
  const double column = std::floor(x), row = std::floor(y);
  if (!(column >= radius && row >= radius && column + radius < linear.width() && row + radius < linear.height())) return false;
  Vec3d sum;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const float* p = linear.pixel(static_cast<int>(column) + dx, static_cast<int>(row) + dy);
      for (size_t c = 0; c < 3; ++c) {
        if (!(p[c] < kClipped)) return false;
        sum[c] += static_cast<double>(p[c]);
      }
    }
  }
  const double n = (2 * radius + 1) * (2 * radius + 1);
  colour = cast<float>(sum / n);
  return std::isfinite(colour.x) && std::isfinite(colour.y) && std::isfinite(colour.z);
}

std::vector<GainSample> track_samples(const ColmapModel& model, const std::function<ImageF(const ColmapImage&)>& linear_photo) {
  std::vector<std::vector<GainSample>> of_view(model.images.size());
  parallel_for(model.images.size(), 1, [&](size_t v) {
    const ColmapImage& image = model.images[v];
    const ImageF photo = linear_photo(image);
    for (const ColmapPoint2D& p : image.points) {
      if (p.point3d_id == kNoPoint3D) continue;
      const ColmapPoint3D* point = model.find_point(p.point3d_id);
      GainSample sample{static_cast<uint32_t>(v), 0, {}};
      if (!point || !sample_colour(photo, p.x, p.y, kRadius, sample.linear_rgb)) continue;
      sample.point = static_cast<uint32_t>(point - model.points.data());
      of_view[v].push_back(sample);
    }
  });
  std::vector<GainSample> samples;
  for (const std::vector<GainSample>& some : of_view) samples.insert(samples.end(), some.begin(), some.end());
  return samples;
}

}  // namespace vitrine
