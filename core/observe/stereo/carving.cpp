#include "core/observe/stereo/carving.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/scene/camera/projection.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {

namespace {

constexpr float kInside = 0.5f;  // coverage

// Bilinear coverage that ignores unknown pixels; negative: all are unknown.
float interpolated(const ImageF& value, double x, double y) {
  const double u = std::clamp(x - 0.5, 0.0, double(value.width() - 1)), v = std::clamp(y - 0.5, 0.0, double(value.height() - 1));
  const int left = std::max(std::min(int(u), value.width() - 2), 0), top = std::max(std::min(int(v), value.height() - 2), 0);
  double sum = 0, weights = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const float at = value.at(std::min(left + i, value.width() - 1), std::min(top + j, value.height() - 1));
      if (at < 0) continue;
      const double w = (i ? u - left : 1 - (u - left)) * (j ? v - top : 1 - (v - top));
      sum += w * double(at), weights += w;
    }
  return weights > 0 ? static_cast<float>(sum / weights) : -1.f;
}

}  // namespace

Carving::Counts::Counts(const ImageF& value) : width_(value.width()), height_(value.height()) {
  const size_t row = size_t(width_) + 1;
  sums_.assign(row * (size_t(height_) + 1), 0);
  for (int y = 0; y < height_; ++y) {
    uint32_t in_row = 0;
    for (int x = 0; x < width_; ++x) {
      in_row += value.at(x, y) >= kInside;
      sums_[size_t(y + 1) * row + size_t(x) + 1] = sums_[size_t(y) * row + size_t(x) + 1] + in_row;
    }
  }
}

bool Carving::Counts::any_near(int u, int v, int radius) const {
  const size_t row = size_t(width_) + 1;
  const auto left = size_t(std::max(u - radius, 0)), right = size_t(std::min(u + radius + 1, width_));
  const auto top = size_t(std::max(v - radius, 0)), bottom = size_t(std::min(v + radius + 1, height_));
  return sums_[bottom * row + right] + sums_[top * row + left] > sums_[top * row + right] + sums_[bottom * row + left];
}

Carving::Carving(std::span<const Silhouette> silhouettes, const CarvingRule& rule, bool widened)
    : silhouettes_(silhouettes), rule_(rule) {
  if (widened)
    for (const Silhouette& s : silhouettes) counts_.emplace_back(s.value);
}

bool Carving::near_inside(size_t index, int u, int v, double slope) const {
  VITRINE_CHECK(index < counts_.size(), "carving with a slack needs silhouettes that may be widened");
  return counts_[index].any_near(u, v, int(std::ceil(slope * silhouettes_[index].view.intrinsics.fx)));
}

bool Carving::enough(size_t inside) const {
  return inside >= rule_.fewest_views && inside >= size_t(rule_.seen_share * double(silhouettes_.size()));
}

bool Carving::inside(const Vec3d& p, double near, double slack) const {
  size_t inside = 0, outside = 0;
  const double most = rule_.outlier_share * double(silhouettes_.size());
  for (const Silhouette& s : silhouettes_) {
    const auto q = image_point(p, s.view, near);
    if (!q) continue;
    const int u = int(q->x), v = int(q->y);
    const float value = s.value.at(u, v);
    if (value < 0) continue;
    if (value >= kInside || (slack > 0 && near_inside(size_t(&s - silhouettes_.data()), u, v, slack / q->z)))
      ++inside;
    else if (double(++outside) > most)
      return false;
  }
  return enough(inside) && double(outside) <= rule_.outlier_share * double(inside + outside);
}

float Carving::occupancy(const Vec3d& p, std::vector<float>& scratch) const {
  scratch.clear();
  size_t inside = 0;
  for (const Silhouette& s : silhouettes_) {
    const auto q = image_point(p, s.view);
    if (!q) continue;
    const float value = interpolated(s.value, q->x, q->y);
    if (value < 0) continue;
    inside += value >= kInside;
    scratch.push_back(value);
  }
  if (!enough(inside)) return 0;
  return order_statistic_of(std::span(scratch), size_t(rule_.outlier_share * double(scratch.size())));
}

}  // namespace vitrine
