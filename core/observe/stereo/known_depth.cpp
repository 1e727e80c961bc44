#include "core/observe/stereo/known_depth.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {

namespace {

constexpr int kSmoothRadius = 2;     // pixels
constexpr float kOneSurface = 0.1f;  // largest relative difference of depths of one surface

// Median of the depths that the known neighbours give this pixel, moved along its plane: noise of the sensor would move the
// surfels off the surface. `normal`: of the pixel.
float smoothed_depth(const KnownDepth& known, const Intrinsics& k, int x, int y, const Vec3d& normal) {
  const float own = known.zdepth.at(x, y);
  const double facing = dot(normal, k.ray(x + 0.5, y + 0.5));
  std::vector<float> depths;
  for (int v = std::max(y - kSmoothRadius, 0); v <= std::min(y + kSmoothRadius, k.height - 1); ++v)
    for (int u = std::max(x - kSmoothRadius, 0); u <= std::min(x + kSmoothRadius, k.width - 1); ++u) {
      const double z = double(known.zdepth.at(u, v)) * dot(normal, k.ray(u + 0.5, v + 0.5)) / facing;
      if (std::abs(z / double(own) - 1) < double(kOneSurface)) depths.push_back(static_cast<float>(z));
    }
  return depths.empty() ? own : upper_median_of(std::span<float>(depths));
}

// A map of the known pixels alone; the normal of an unknown one is 0, with which nothing agrees.
DepthMap map_of(const KnownDepth& known, const Intrinsics& k, const DepthMap& stereo) {
  const size_t pixels = stereo.zdepth.size();
  VITRINE_CHECK(known.zdepth.pixel_count() == pixels && known.normal.size() == pixels && k.pixel_count() == pixels,
                "{} known depths for {} pixels", known.zdepth.pixel_count(), pixels);
  DepthMap map{stereo.width,
               stereo.height,
               std::vector<float>(pixels, 0.f),
               std::vector<Vec3f>(pixels),
               std::vector<float>(pixels, -1.f),
               std::vector<uint8_t>(pixels, 0),
               std::vector<uint8_t>(pixels, 0)};
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t i = k.index(x, y);
      const Vec3d normal = cast<double>(known.normal[i]);
      if (!(known.zdepth.at(x, y) > 0 && dot(normal, k.ray(x + 0.5, y + 0.5)) < 0)) continue;
      map.zdepth[i] = smoothed_depth(known, k, x, y, normal);
      map.normal[i] = known.normal[i];
      map.score[i] = 1;
    }
  return map;
}

}  // namespace

size_t join_known_depth(std::span<const StereoPhoto> photos, std::span<const KnownDepth> known, std::span<DepthMap> maps) {
  std::vector<DepthMap> given(maps.size());
  parallel_for(maps.size(), 1, [&](size_t v) {
    if (!known[v].empty() && !maps[v].zdepth.empty()) given[v] = map_of(known[v], photos[v].view.intrinsics, maps[v]);
  });
  count_agreement(photos, given);
  size_t replaced = 0;
  for (size_t v = 0; v < maps.size(); ++v)
    for (size_t i = 0; i < given[v].zdepth.size(); ++i) {
      if (!given[v].reliable(i)) continue;
      ++replaced;
      maps[v].zdepth[i] = given[v].zdepth[i];
      maps[v].normal[i] = given[v].normal[i];
      maps[v].score[i] = given[v].score[i];
      maps[v].agreeing[i] = given[v].agreeing[i];
      maps[v].trusted[i] = 1;
    }
  return replaced;
}

float depth_near(const ImageF& map, double x, double y, double width, double height) {
  const auto range = [](double at, double size, int limit) {
    const int first = int(std::floor(at - size / 2 + 0.5)), last = int(std::floor(at + size / 2 - 0.5));
    const int centre = std::clamp(int(std::floor(at)), 0, limit - 1);
    return std::pair(std::clamp(first, 0, centre), std::clamp(last, centre, limit - 1));
  };
  const auto [x0, x1] = range(x, width, map.width());
  const auto [y0, y1] = range(y, height, map.height());
  if (x0 == x1 && y0 == y1) return map.at(x0, y0);
  std::vector<float> known;
  for (int v = y0; v <= y1; ++v)
    for (int u = x0; u <= x1; ++u)
      if (map.at(u, v) > 0) known.push_back(map.at(u, v));
  const size_t pixels = size_t(x1 - x0 + 1) * size_t(y1 - y0 + 1);
  if (2 * known.size() < pixels) return 0;
  return quantile_of(known, 0.5);  // of two middle depths the nearer
}

ImageF resized_depth(const ImageF& map, int width, int height) {
  if (map.width() == width && map.height() == height) return map;
  ImageF out(width, height, 1);
  const double sx = double(map.width()) / width, sy = double(map.height()) / height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) out.at(x, y) = depth_near(map, (x + 0.5) * sx, (y + 0.5) * sy, sx, sy);
  return out;
}

std::filesystem::path known_depth_path(const std::filesystem::path& artifact, const View& view) {
  return artifact / "depth" / (view.stem() + ".exr");
}

}  // namespace vitrine
