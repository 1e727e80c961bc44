#include "core/observe/stereo/mask_rows.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vitrine {

namespace {

constexpr double kCountedPhotos = 0.75;

}  // namespace

RowSpans no_spans(const View& view) { return RowSpans(size_t(view.intrinsics.height), {1e9, -1e9}); }

void add_segment(Vec2d a, Vec2d b, RowSpans& spans) {
  if (a.y > b.y) std::swap(a, b);
  const double rows = double(spans.size());
  const int first = int(std::ceil(std::clamp(a.y - 0.5, 0.0, rows))),
            last = int(std::floor(std::clamp(b.y - 0.5, -1.0, rows - 1)));
  for (int y = first; y <= last; ++y) {
    const double x = b.y > a.y ? a.x + (y + 0.5 - a.y) / (b.y - a.y) * (b.x - a.x) : a.x;
    spans[size_t(y)] = {std::min(spans[size_t(y)][0], x), std::max(spans[size_t(y)][1], x)};
  }
}

std::vector<uint8_t> pixels_of(const RowSpans& spans, const View& view) {
  const Intrinsics& k = view.intrinsics;
  std::vector<uint8_t> inside(k.pixel_count(), 0);
  for (size_t y = 0; y < spans.size(); ++y) {
    const int first = int(std::ceil(std::clamp(spans[y][0] - 0.5, 0.0, double(k.width))));
    for (int x = first; x < k.width && x + 0.5 <= spans[y][1]; ++x) inside[y * size_t(k.width) + size_t(x)] = 1;
  }
  return inside;
}

MaskRows::MaskRows(const Silhouette& m) : view_(m.view), width_(m.value.width()), height_(m.value.height()) {
  mask_.assign(size_t(height_) * stride(), 0.f);
  known_ = mask_;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const float value = m.value.at(x, y);
      const size_t i = size_t(y) * stride() + size_t(x);
      mask_[i + 1] = mask_[i] + (value >= 0.5f ? 1.f : 0.f);
      known_[i + 1] = known_[i] + (value < 0 ? 0.f : 1.f);
    }
  for (int y = 0; y < height_; ++y) all_ += double(mask_[size_t(y + 1) * stride() - 1]);
}

double MaskRows::left_of(const std::vector<float>& sums, int y, double x) const {
  const double at = std::clamp(x, 0.0, double(width_));
  const auto i = std::min(size_t(at), size_t(width_) - 1);
  const float* row = sums.data() + size_t(y) * stride();
  return double(row[i]) + (at - double(i)) * double(row[i + 1] - row[i]);
}

double MaskRows::agreement(const RowSpans& spans) const {
  double both = 0, silhouette = 0;
  for (size_t y = 0; y < spans.size(); ++y) {
    if (!(spans[y][1] > spans[y][0])) continue;
    both += left_of(mask_, int(y), spans[y][1]) - left_of(mask_, int(y), spans[y][0]);
    silhouette += left_of(known_, int(y), spans[y][1]) - left_of(known_, int(y), spans[y][0]);
  }
  return both / std::max(all_ + silhouette - both, 1.0);
}

double mean_of_better(std::vector<double> agreements) {
  if (agreements.empty()) return 0;
  std::sort(agreements.begin(), agreements.end(), std::greater<>());
  const size_t counted = std::max<size_t>(1, size_t(std::ceil(kCountedPhotos * double(agreements.size()))));
  double sum = 0;
  for (size_t i = 0; i < counted; ++i) sum += agreements[i];
  return sum / double(counted);
}

}  // namespace vitrine
