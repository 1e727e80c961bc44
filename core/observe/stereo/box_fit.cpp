#include "core/observe/stereo/box_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"
#include "core/observe/stereo/mask_rows.h"

namespace vitrine {

namespace {

constexpr int kTurns = 6;                                                  // initial rotations, over a quarter turn about z
constexpr double kFirstStep = 0.08, kCoarseStep = 0.01, kLastStep = 2e-4;  // of the box diagonal; radians for angles

double mean_agreement(const std::vector<MaskRows>& photos, const Box& box) {
  std::vector<double> each(photos.size());
  parallel_for(photos.size(), 4, [&](size_t i) { each[i] = photos[i].agreement(spans_of_box(box, photos[i].view())); });
  return mean_of_better(std::move(each));
}

std::vector<MaskRows> rows_of(std::span<const Silhouette> masks) {
  std::vector<MaskRows> photos;
  for (const Silhouette& m : masks) {
    photos.emplace_back(m);
    if (photos.back().says_nothing()) photos.pop_back();
  }
  return photos;
}

}  // namespace

RowSpans spans_of_box(const Box& box, const View& view) {
  std::array<Vec2d, 8> corners;
  for (size_t i = 0; i < 8; ++i) {
    const auto p = projection(box.corner(i), view, 1e-6);
    if (!p) return {};
    corners[i] = {p->x, p->y};
  }
  RowSpans spans = no_spans(view);
  for (size_t i = 0; i < 8; ++i)
    for (size_t bit = 1; bit < 8; bit *= 2)
      if (!(i & bit)) add_segment(corners[i], corners[i | bit], spans);
  return spans;
}

double agreement(std::span<const Silhouette> masks, const Box& box) {
  const std::vector<MaskRows> photos = rows_of(masks);
  return photos.empty() ? 0 : mean_agreement(photos, box);
}

std::optional<BoxFit> fit_box(std::span<const Silhouette> masks, const Bounds3& about, double least) {
  const std::vector<MaskRows> photos = rows_of(masks);
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

std::vector<uint8_t> silhouette_mask(const Box& box, const View& view) { return pixels_of(spans_of_box(box, view), view); }

Mat3d turned(size_t axis, double angle) {
  Quatd q{std::cos(angle / 2), 0, 0, 0};
  (axis == 0 ? q.x : axis == 1 ? q.y : q.z) = std::sin(angle / 2);
  return rotation_matrix(q);
}

Box moved(const Box& box, size_t i, double step) {
  Box out = box;
  if (i < 6) {
    const size_t axis = i / 2;
    (i % 2 == 0 ? out.low : out.high)[axis] += (i % 2 == 0 ? -1 : 1) * step * length(box.high - box.low);
    return out;
  }
  const Vec3d middle = box.axes * (0.5 * (box.low + box.high));
  out.axes = box.axes * turned(i - 6, step);
  const Vec3d shift = transposed_times(out.axes, middle) - 0.5 * (box.low + box.high);
  out.low += shift, out.high += shift;
  return out;
}

}  // namespace vitrine
