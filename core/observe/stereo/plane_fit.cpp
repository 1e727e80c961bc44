#include "core/observe/stereo/plane_fit.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/pattern_search.h"
#include "core/observe/stereo/box_fit.h"
#include "core/observe/stereo/plane_silhouette.h"

namespace vitrine {

namespace {

constexpr double kLeastPicture = 0.003;                                    // minimum rectangle size, of a photo's pixels
constexpr size_t kFewestShowing = 4;                                       // photos with a mask component
constexpr double kLeastStart = 0.35;                                       // minimum initial IoU of a candidate
constexpr double kWideStep = 0.06, kMiddleStep = 0.008, kFineStep = 2e-4;  // of the diagonal; radians for angles
constexpr int kLookAgain = 3;            // rounds: each selects the mask components of the improved rectangle
constexpr double kThickness_rel = 0.1;   // of the rectangle's size: initial half thickness of the box
constexpr double kClearlyBetter = 0.02;  // IoU difference
constexpr size_t kFewestFromBehind = 2;
constexpr size_t kMostPlaneFits = 12;
constexpr double kWiden_px = 0.012;  // of the picture's longest side: margin around an accepted rectangle that becomes unknown
constexpr std::array<size_t, 8> kPlaneNumbers{0, 1, 2, 3, 4, 5, 6, 7};

// Parameters 0 to 3 move sides outwards; 4 to 6 rotate about the axes; 7 moves away from `eye` and scales to the same image size.
std::optional<Plane> moved_plane(const Plane& plane, size_t i, double step, const Vec3d& eye) {
  Plane out = plane;
  const double diagonal = 2 * std::hypot(plane.half.x, plane.half.y);
  if (i < 4) {
    const size_t axis = i / 2;
    const double shift = 0.5 * step * diagonal;
    out.half[axis] += shift;
    out.centre += (i % 2 == 0 ? -shift : shift) * plane.axes.column(axis);
    if (!(out.half[axis] > 0)) return std::nullopt;
  } else if (i < 7) {
    out.axes = plane.axes * turned(i - 4, step);
  } else {
    const double distance = length(plane.centre - eye), scale = 1 + step * diagonal / distance;
    if (!(scale > 0)) return std::nullopt;
    out.centre = eye + scale * (plane.centre - eye);
    out.half = scale * plane.half;
  }
  return out;
}

// Marks the pixels on and near the rectangle as unknown.
void take_out(const Plane& plane, std::vector<Silhouette>& masks) {
  parallel_for(masks.size(), 1, [&](size_t v) {
    Silhouette& mask = masks[v];
    const RowSpans spans = spans_of_plane(plane, mask.view);
    const int reach = int(std::ceil(kWiden_px * mask.view.intrinsics.longest_side())), width = mask.value.width();
    for (int y = 0; y < int(spans.size()); ++y) {
      if (spans[size_t(y)][1] < spans[size_t(y)][0]) continue;
      const int left = int(std::clamp(spans[size_t(y)][0] - reach, 0.0, double(width)));
      const int right = int(std::clamp(spans[size_t(y)][1] + reach, 0.0, double(width)));
      for (int row = std::max(0, y - reach); row <= std::min(int(spans.size()) - 1, y + reach); ++row)
        for (int x = left; x < right; ++x) mask.value.at(x, row) = -1;
    }
  });
}

// Whether a box centred on the rectangle has a clearly better IoU: the object has depth.
bool is_deep(const PlaneFit& fit, std::span<const Silhouette> masks) {
  const PlaneMasks photos(masks, fit.plane);
  const Vec3d half{fit.plane.half.x, fit.plane.half.y, kThickness_rel * fit.plane.size()};
  const Vec3d centre = transposed_times(fit.plane.axes, fit.plane.centre);
  Box box{fit.plane.axes, centre - half, centre + half};
  const auto score = [&](const Box& b) { return photos.agreement([&](const View& view) { return spans_of_box(b, view); }); };
  return improve(score, kWideStep, kMiddleStep, box) > photos.agreement(fit.plane) + kClearlyBetter;
}

// Whether photos from behind see it too, so that it does not hang on a wall.
bool is_seen_from_behind(const Plane& plane, std::span<const Silhouette> masks) {
  Plane back = plane;
  back.axes = {plane.axes.c0, -plane.axes.c1, -plane.axes.c2};
  std::vector<uint8_t> shown(masks.size(), 0);
  parallel_for(masks.size(), 1, [&](size_t v) {
    if (!faces(back, masks[v].view)) return;
    const std::vector<uint8_t> inside = pixels_of(spans_of_plane(back, masks[v].view), masks[v].view);
    size_t all = 0, marked = 0;
    for (size_t i = 0; i < inside.size(); ++i) all += inside[i], marked += inside[i] && masks[v].value.data()[i] >= 0.5f;
    shown[v] = double(all) >= kLeastPicture * double(inside.size()) && 2 * marked > all;
  });
  return size_t(std::ranges::count(shown, 1)) >= kFewestFromBehind;
}

std::optional<PlaneFit> first_that_agrees(std::span<const Plane> candidates, std::span<const Silhouette> masks,
                                          const PlaneFitDesc& desc) {
  for (const Plane& start : candidates) {
    const auto fit = refined_plane(masks, start, desc.least);
    if (fit && !(desc.one_sided && is_seen_from_behind(fit->plane, masks)) && !is_deep(*fit, masks)) return fit;
  }
  return std::nullopt;
}

}  // namespace

std::optional<PlaneFit> refined_plane(std::span<const Silhouette> masks, const Plane& start, double least) {
  PlaneFit best{start, 0};
  for (int look = 0; look < kLookAgain; ++look) {
    const PlaneMasks photos(masks, best.plane);
    if (photos.marked() < kFewestShowing || photos.picture_share() < kLeastPicture) return std::nullopt;
    const auto score = [&](const Plane& plane) { return photos.agreement(plane); };
    const auto move = [eye = photos.mean_camera()](const Plane& plane, size_t i, double step) {
      return moved_plane(plane, i, step, eye);
    };
    if (look == 0 && score(best.plane) < kLeastStart) return std::nullopt;
    const PatternSteps steps =
        look + 1 < kLookAgain ? PatternSteps{kWideStep, kMiddleStep} : PatternSteps{kMiddleStep, kFineStep};
    best.agreement = pattern_search(score, move, steps, kPlaneNumbers, best.plane);
    if (best.agreement < (look + 1 < kLookAgain ? 0.8 * least : least)) return std::nullopt;
  }
  return best;
}

std::vector<PlaneFit> fit_planes(std::span<const Silhouette> masks, std::span<const Vec3d> points, const PlaneFitDesc& desc) {
  std::vector<Silhouette> rest(masks.begin(), masks.end());
  std::vector<PlaneFit> out;
  while (out.size() < kMostPlaneFits) {
    auto fit = first_that_agrees(candidates_of_outlines(rest, kLeastPicture), rest, desc);
    if (!fit) fit = first_that_agrees(candidates_of_points(rest, points, desc.inside_weight), rest, desc);
    if (!fit) break;
    take_out(fit->plane, rest);
    out.push_back(*fit);
  }
  return out;
}

}  // namespace vitrine
