#include "stages/masks/proposed/view_dependence.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/process.h"
#include "core/camera/projection.h"
#include "core/math/median.h"

namespace vitrine {

namespace {

constexpr float kResidualBlur = 2;   // pixels of the small photo: edges that lie a pixel off cancel
constexpr float kWindow = 4;         // pixels: reflections are patchy
constexpr float kCap = 0.08f;        // one glint must not speak for its whole window
constexpr size_t kFewestViews = 8;   // that see a point, for a median that means something
constexpr double kSameDepth = 0.05;  // relative: the other view sees this point, not one in front of it
constexpr float kDepthEdge = 1.12f;  // ratio of depths within two pixels: the fit's outlines are not sharp
constexpr float kKnownShare = 0.3f;  // of a window with a value
constexpr double kNearest = 0.05;

float bilinear(const float* plane, int w, int h, double x, double y) {
  const double fx = std::clamp(x - 0.5, 0.0, w - 1.0), fy = std::clamp(y - 0.5, 0.0, h - 1.0);
  const int x0 = std::min(int(fx), std::max(w - 2, 0)), y0 = std::min(int(fy), std::max(h - 2, 0));
  const int x1 = std::min(x0 + 1, w - 1), y1 = std::min(y0 + 1, h - 1);
  const float u = float(fx - x0), v = float(fy - y0);
  return (1 - v) * ((1 - u) * plane[y0 * w + x0] + u * plane[y0 * w + x1]) +
         v * ((1 - u) * plane[y1 * w + x0] + u * plane[y1 * w + x1]);
}

bool at_depth_edge(const std::vector<float>& z, int w, int h, int x, int y) {
  float low = 1e30f, high = 0;
  for (int j = std::max(0, y - 2); j <= std::min(h - 1, y + 2); ++j)
    for (int i = std::max(0, x - 2); i <= std::min(w - 1, x + 2); ++i) {
      low = std::min(low, z[size_t(j) * size_t(w) + size_t(i)]);
      high = std::max(high, z[size_t(j) * size_t(w) + size_t(i)]);
    }
  return !(high < kDepthEdge * low);
}

}  // namespace

std::vector<DeviationMap> view_dependence(const std::vector<SmallPhoto>& photos, const QuickFit& fit) {
  const size_t count = photos.size();
  std::vector<std::vector<float>> residuals(count);
  parallel_for(count, 1, [&](size_t v) {
    const Intrinsics& k = photos[v].view.intrinsics;
    residuals[v].resize(photos[v].srgb.size());
    for (size_t i = 0; i < residuals[v].size(); ++i) residuals[v][i] = photos[v].srgb[i] - fit.views[v].srgb[i];
    blur_planes(residuals[v], k.width, k.height, kResidualBlur);
  });
  std::vector<DeviationMap> maps(count);
  parallel_for(count, 1, [&](size_t v) {
    throw_if_interrupted();
    const Intrinsics& k = photos[v].view.intrinsics;
    const int w = k.width, h = k.height;
    const size_t pixels = size_t(w) * size_t(h);
    const Rigid world_from_cam = inverse(photos[v].view.cam_from_world);
    std::vector<float> sums(2 * pixels, 0.f);  // deviation, and where there is one
    std::array<std::vector<float>, 3> samples;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const size_t pixel = size_t(y) * size_t(w) + size_t(x);
        const double z = fit.views[v].zdepth[pixel];
        if (!(z > 0) || at_depth_edge(fit.views[v].zdepth, w, h, x, y)) continue;
        const Vec3d point = world_from_cam * (z * k.ray(x + 0.5, y + 0.5));
        for (auto& s : samples) s.clear();
        for (size_t u = 0; u < count; ++u) {
          if (u == v) continue;
          const auto p = image_point(point, photos[u].view, kNearest, 1);
          if (!p) continue;
          const Intrinsics& ku = photos[u].view.intrinsics;
          const double seen = fit.views[u].zdepth[size_t(p->y) * size_t(ku.width) + size_t(p->x)];
          if (!(std::abs(seen - p->z) < kSameDepth * p->z)) continue;
          const size_t plane = size_t(ku.width) * size_t(ku.height);
          for (size_t c = 0; c < 3; ++c)
            samples[c].push_back(bilinear(&residuals[u][c * plane], ku.width, ku.height, p->x, p->y));
        }
        if (samples[0].size() < kFewestViews) continue;
        float squared = 0, common_squared = 0;
        for (size_t c = 0; c < 3; ++c) {
          const float common = upper_median_of(std::span<float>(samples[c])), d = residuals[v][c * pixels + pixel] - common;
          squared += d * d;
          common_squared += common * common;
        }
        sums[pixel] = std::clamp(std::sqrt(squared / 3) - std::sqrt(common_squared / 3), 0.f, kCap);
        sums[pixels + pixel] = 1;
      }
    blur_planes(sums, w, h, kWindow);
    maps[v] = {w, h, std::vector<float>(pixels, NAN)};
    for (size_t i = 0; i < pixels; ++i)
      if (sums[pixels + i] > kKnownShare) maps[v].value[i] = sums[i] / sums[pixels + i];
  });
  return maps;
}

}  // namespace vitrine
