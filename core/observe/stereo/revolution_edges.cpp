
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/observe/stereo/revolution_fit.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr int kEdgeHeights = 48;         // of the profile
constexpr int kEdgeSteps = 20;           // candidate radii on each side of a start
constexpr double kEdgeReach = 0.125;     // search range, of the largest radius; halved after each round
constexpr double kEdgeHalfWidth = 1.25;  // pixels: offset of the two samples on either side of an edge
constexpr float kEdgeContrast = 0.15f;   // sum of three channels: contrast with edge strength one half
constexpr double kEdgeBend = 0.004;      // smoothness cost per squared radius step between two heights, in edge strength
constexpr double kEdgeSteepest = 0.8;    // maximum slope of radius over height: beyond it rims of lids and feet are edges too
constexpr double kEdgeTouch = 0.98;      // maximum |cosine|: seen nearly from above the rim is no contour
constexpr double kEdgeFirstMove = 0.05, kEdgeLastMove = 5e-4;  // of the largest radius; radians for the tilt
constexpr int kEdgeRounds = 3;                                 // alternating fits of radii and axis
constexpr size_t kEdgeFewest = 10;                             // minimum observations per height, two per photo

using EdgeRadii = std::array<double, kEdgeHeights>;
using EdgeRow = std::array<double, 2 * kEdgeSteps + 1>;  // strength at each candidate radius

// Normalised contrast across the silhouette at `p` with surface normal `normal`; negative: not visible.
float edge_at(const EdgePhoto& photo, const Vec3d& p, const Vec3d& normal) {
  const Intrinsics& k = photo.view.intrinsics;
  const Vec3d q = photo.view.cam_from_world * p, n = photo.view.cam_from_world.rotation * normal;
  const auto at = image_point(q, k, 1e-6, 2);
  if (!at) return -1;
  double dx = k.fx * (n.x - n.z * q.x / q.z), dy = k.fy * (n.y - n.z * q.y / q.z);
  const double norm = std::hypot(dx, dy);
  if (!(norm > 0)) return -1;
  dx *= kEdgeHalfWidth / norm, dy *= kEdgeHalfWidth / norm;
  float out[3], in[3];
  sample_bilinear(photo.srgb, at->x + dx, at->y + dy, out);
  sample_bilinear(photo.srgb, at->x - dx, at->y - dy, in);
  const float change = std::abs(out[0] - in[0]) + std::abs(out[1] - in[1]) + std::abs(out[2] - in[2]);
  return change / (change + kEdgeContrast);
}

class Edges {
 public:
  Edges(std::span<const EdgePhoto> photos, const EdgeRadii& start, double low, double step, double reach)
      : photos_(photos), start_(start), low_(low), step_(step), reach_(reach * *std::ranges::max_element(start)) {}

  // The radii with the highest total edge strength; returns its mean per height.
  double best(const TurningAxis& axis, EdgeRadii& radii) const {
    std::array<EdgeRow, kEdgeHeights> rows;
    parallel_for(kEdgeHeights, 2, [&](size_t i) { rows[i] = row(axis, i); });
    // Dynamic programming over the heights.
    std::array<EdgeRow, kEdgeHeights> sums;
    std::array<std::array<int, 2 * kEdgeSteps + 1>, kEdgeHeights> before{};
    sums[0] = rows[0];
    for (size_t i = 1; i < kEdgeHeights; ++i)
      for (int k = 0; k < int(rows[i].size()); ++k) {
        double most = -1e300;
        for (int j = std::max(0, k - 4); j <= std::min(2 * kEdgeSteps, k + 4); ++j)
          if (const double s = sums[i - 1][size_t(j)] - kEdgeBend * (k - j) * (k - j); s > most)
            most = s, before[i][size_t(k)] = j;
        sums[i][size_t(k)] = most + rows[i][size_t(k)];
      }
    int k = int(std::ranges::max_element(sums.back()) - sums.back().begin());
    const double total = sums.back()[size_t(k)];
    for (size_t i = kEdgeHeights; i-- > 0; k = before[i][size_t(k)]) {
      double peak = k;
      if (k > 0 && k < 2 * kEdgeSteps) {  // vertex of the parabola through three samples
        const double a = rows[i][size_t(k - 1)], b = rows[i][size_t(k)], c = rows[i][size_t(k + 1)];
        if (2 * b - a - c > 1e-9) peak += std::clamp(0.5 * (c - a) / (2 * b - a - c), -0.5, 0.5);
      }
      radii[i] = std::max(radius(i, peak), 1e-6);
    }
    return total / kEdgeHeights;
  }

 private:
  double radius(size_t i, double k) const { return start_[i] + reach_ * (k - kEdgeSteps) / kEdgeSteps; }

  // Edge strengths at one height. The contour of a disc's rim is where the line of sight touches the surface.
  EdgeRow row(const TurningAxis& axis, size_t i) const {
    EdgeRow sum{};
    std::array<size_t, 2 * kEdgeSteps + 1> count{};
    const size_t below = i == 0 ? i : i - 1, above = i + 1 == kEdgeHeights ? i : i + 1;
    const double slope = (start_[above] - start_[below]) / (step_ * double(above - below));
    if (std::abs(slope) > kEdgeSteepest) return sum;  // no estimate: moved with the neighbouring heights
    const Vec3d centre = axis.origin + (low_ + step_ * double(i)) * axis.along;
    for (const EdgePhoto& photo : photos_) {
      const Vec3d to_camera = photo.view.centre_in_world() - centre;
      const double x = dot(to_camera, axis.u), y = dot(to_camera, axis.v), distance = std::hypot(x, y);
      const double cosine = (start_[i] + slope * dot(to_camera, axis.along)) / distance;
      if (!(std::abs(cosine) < kEdgeTouch)) continue;
      for (double side : {-1.0, 1.0}) {
        const double angle = std::atan2(y, x) + side * std::acos(cosine);
        const Vec3d out = std::cos(angle) * axis.u + std::sin(angle) * axis.v;
        const Vec3d normal = normalized(out - slope * axis.along);
        for (size_t k = 0; k < sum.size(); ++k) {
          const double r = radius(i, double(k));
          if (!(r > 0)) continue;
          if (const float edge = edge_at(photo, centre + r * out, normal); edge >= 0) sum[k] += double(edge), ++count[k];
        }
      }
    }
    for (size_t k = 0; k < sum.size(); ++k) sum[k] = count[k] >= kEdgeFewest ? sum[k] / double(count[k]) : 0;
    return sum;
  }

  std::span<const EdgePhoto> photos_;
  const EdgeRadii& start_;
  double low_, step_, reach_;
};

}  // namespace

SurfaceOfRevolution drawn_to_edges(const SurfaceOfRevolution& start, std::span<const EdgePhoto> photos) {
  const std::span<const Vec2d> side = std::span(start.profile).subspan(1, start.profile.size() - 2);  // without the flat ends
  if (2 * photos.size() < kEdgeFewest || start.profile.size() < 4) return start;
  EdgeRadii radii;
  const double first = side.front().y, step = (side.back().y - first) / (kEdgeHeights - 1);
  size_t j = 0;
  for (size_t i = 0; i < kEdgeHeights; ++i) {
    const double height = first + step * double(i);
    while (j + 2 < side.size() && side[j + 1].y < height) ++j;
    radii[i] = side[j].x + (height - side[j].y) / (side[j + 1].y - side[j].y) * (side[j + 1].x - side[j].x);
  }
  const double middle = 0.5 * (first + side.back().y), low = first - middle;  // midpoint of the axis, the centre of its rotations
  const Vec3d origin = start.origin + middle * start.axis;
  AxisPlace place{origin.x, origin.y, start.axis.x / start.axis.z, start.axis.y / start.axis.z};
  const auto axis = [&](const AxisPlace& p) { return turning_axis({p[0], p[1], origin.z}, p[2], p[3]); };
  const double largest = *std::ranges::max_element(radii);
  for (int round = 0; round < kEdgeRounds; ++round) {
    const EdgeRadii now = radii;
    const Edges edges(photos, now, low, step, kEdgeReach / (1 << round));
    improve_axis(
        largest, kEdgeFirstMove / (1 << round), kEdgeLastMove, 4,
        [&](const AxisPlace& p) {
          EdgeRadii trial;
          return edges.best(axis(p), trial);
        },
        place);
    edges.best(axis(place), radii);
    for (int pass = 0; pass < 2; ++pass) {
      const EdgeRadii rough = radii;
      for (size_t i = 1; i + 1 < kEdgeHeights; ++i) radii[i] = (rough[i - 1] + 2 * rough[i] + rough[i + 1]) / 4;
    }
  }
  const TurningAxis a = axis(place);
  return revolved(a.origin, a.along, low, step, radii);
}

}  // namespace vitrine
