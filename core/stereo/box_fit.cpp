#include "core/stereo/box_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/parallel.h"
#include "core/camera/projection.h"
#include "core/stereo/box_search.h"

namespace vitrine {

namespace {

constexpr int kTurns = 6;                                                  // starts, over a quarter of a turn about z
constexpr double kFirstStep = 0.08, kCoarseStep = 0.01, kLastStep = 2e-4;  // of the box's diagonal; radians for angles
constexpr double kCounted = 0.75;                                          // of the photos, the better ones

// A mask row by row: how much of it, and how much that says anything at all, lies left of x.
class RowSums {
 public:
  explicit RowSums(const Silhouette& m) : view_(m.view), width_(m.value.width()), height_(m.value.height()) {
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
  bool says_nothing() const { return all_ == 0; }

  double agreement(const Box& box) const;

 private:
  size_t stride() const { return size_t(width_) + 1; }
  double left_of(const std::vector<float>& sums, int y, double x) const {
    const double at = std::clamp(x, 0.0, double(width_));
    const auto i = std::min(size_t(at), size_t(width_) - 1);
    const float* row = sums.data() + size_t(y) * stride();
    return double(row[i]) + (at - double(i)) * double(row[i + 1] - row[i]);
  }

  View view_;
  int width_, height_;
  std::vector<float> mask_, known_;
  double all_ = 0;
};

// The silhouette of a box: the span [left, right] of every row of pixels, at the height of their centres. Empty if a corner is
// behind the camera.
using Spans = std::vector<std::array<double, 2>>;
Spans silhouette_spans(const Box& box, const View& view) {
  const Intrinsics& k = view.intrinsics;
  std::array<Vec2d, 8> corners;
  for (size_t i = 0; i < 8; ++i) {
    const auto p = projection(box.corner(i), view, 1e-6);
    if (!p) return {};
    corners[i] = {p->x, p->y};
  }
  Spans spans(size_t(k.height), {1e9, -1e9});
  for (size_t i = 0; i < 8; ++i)
    for (size_t bit = 1; bit < 8; bit *= 2) {
      if (i & bit) continue;
      Vec2d a = corners[i], b = corners[i | bit];
      if (a.y > b.y) std::swap(a, b);
      const int first = std::max(0, int(std::ceil(a.y - 0.5))), last = std::min(k.height - 1, int(std::floor(b.y - 0.5)));
      for (int y = first; y <= last; ++y) {
        const double x = b.y > a.y ? a.x + (y + 0.5 - a.y) / (b.y - a.y) * (b.x - a.x) : a.x;
        spans[size_t(y)] = {std::min(spans[size_t(y)][0], x), std::max(spans[size_t(y)][1], x)};
      }
    }
  return spans;
}

double RowSums::agreement(const Box& box) const {
  double both = 0, silhouette = 0;
  const Spans spans = silhouette_spans(box, view_);
  for (size_t y = 0; y < spans.size(); ++y) {
    if (!(spans[y][1] > spans[y][0])) continue;
    both += left_of(mask_, int(y), spans[y][1]) - left_of(mask_, int(y), spans[y][0]);
    silhouette += left_of(known_, int(y), spans[y][1]) - left_of(known_, int(y), spans[y][0]);
  }
  return both / std::max(all_ + silhouette - both, 1.0);
}

double mean_agreement(const std::vector<RowSums>& photos, const Box& box) {
  std::vector<double> each(photos.size());
  parallel_for(photos.size(), 4, [&](size_t i) { each[i] = photos[i].agreement(box); });
  std::sort(each.begin(), each.end(), std::greater<>());
  const size_t counted = std::max<size_t>(1, size_t(std::ceil(kCounted * double(each.size()))));
  double sum = 0;
  for (size_t i = 0; i < counted; ++i) sum += each[i];
  return sum / double(counted);
}

std::vector<RowSums> row_sums(std::span<const Silhouette> masks) {
  std::vector<RowSums> photos;
  for (const Silhouette& m : masks) {
    photos.emplace_back(m);
    if (photos.back().says_nothing()) photos.pop_back();
  }
  return photos;
}

}  // namespace

double agreement(std::span<const Silhouette> masks, const Box& box) {
  const std::vector<RowSums> photos = row_sums(masks);
  return photos.empty() ? 0 : mean_agreement(photos, box);
}

std::optional<BoxFit> fit_box(std::span<const Silhouette> masks, const Bounds3& about, double least) {
  const std::vector<RowSums> photos = row_sums(masks);
  if (photos.empty() || about.empty()) return std::nullopt;
  const Vec3d centre = about.centre();
  const Vec3d half = 0.5 * (about.high - about.low);
  const auto score = [&](const Box& box) { return mean_agreement(photos, box); };
  BoxFit best;
  for (int turn = 0; turn < kTurns; ++turn) {
    Box box{turned(2, std::numbers::pi / 2 * turn / kTurns), {}, {}};
    const Vec3d c = transposed_times(box.axes, centre), h = 0.85 * half;
    box.low = c - h, box.high = c + h;
    if (const double agreement = improve(score, kFirstStep, kCoarseStep, box); agreement > best.agreement)
      best = {box, agreement};
  }
  best.agreement = improve(score, kCoarseStep, kLastStep, best.box);
  if (best.agreement < least) return std::nullopt;
  return best;
}

std::vector<uint8_t> silhouette_mask(const Box& box, const View& view) {
  const Intrinsics& k = view.intrinsics;
  std::vector<uint8_t> inside(size_t(k.width) * size_t(k.height), 0);
  const Spans spans = silhouette_spans(box, view);
  for (size_t y = 0; y < spans.size(); ++y)
    for (int x = std::max(0, int(std::ceil(spans[y][0] - 0.5))); x < k.width && x + 0.5 <= spans[y][1]; ++x)
      inside[y * size_t(k.width) + size_t(x)] = 1;
  return inside;
}

}  // namespace vitrine
