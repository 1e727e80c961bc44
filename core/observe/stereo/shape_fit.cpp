#include "core/observe/stereo/shape_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/quantile.h"
#include "core/observe/stereo/revolution_fit.h"

namespace vitrine {

FittedShapes fit_shapes(std::span<const Silhouette> silhouettes, const VisualHull& hull) {
  FittedShapes out;
  if (hull.empty()) return out;
  out.box = fit_box(silhouettes, hull.bounds());
  if (!out.box) out.solids = surfaces_of_revolution(silhouettes, hull.surface(), hull.voxel());
  for (SurfaceOfRevolution& solid : out.solids)
    if (const auto ball = ball_of(silhouettes, solid)) solid = *ball;
  return out;
}

namespace {

constexpr double kFlank = 0.6;           // of the largest radius: photos from one height see no contour closer to the axis
constexpr size_t kFewestOnFlank = 8;     // points of the profile
constexpr int kBallRounds = 4;           // fits, each to the nearest three quarters of the points
constexpr double kRound = 0.02;          // of the radius: maximum mean distance of these points from the sphere
constexpr double kBallAgreement = 0.92;  // IoU, median over the photos
constexpr double kAsGood = 0.01;         // maximum IoU loss of the sphere
constexpr double kFewestPixels = 100;    // of a mask
constexpr size_t kSegments = 96;

struct Circle {
  double height = 0, radius = 0;  // of the centre on the axis
};

// (r, h) with r^2 + h^2 = 2 c h + (R^2 - c^2): linear in c and R^2 - c^2.
Circle circle_through(std::span<const Vec2d> points) {
  double h = 0, hh = 0, q = 0, hq = 0;
  for (const Vec2d& p : points) {
    const double square = p.x * p.x + p.y * p.y;
    h += p.y, hh += p.y * p.y, q += square, hq += p.y * square;
  }
  const auto n = double(points.size());
  const double slope = (n * hq - h * q) / (n * hh - h * h), c = slope / 2;
  return {c, std::sqrt(std::max(0.0, (q - slope * h) / n + c * c))};
}

double distance(const Circle& circle, const Vec2d& p) { return std::abs(std::hypot(p.x, p.y - circle.height) - circle.radius); }

std::optional<Circle> circle_of_flank(const SurfaceOfRevolution& surface) {
  std::vector<Vec2d> flank;
  for (const Vec2d& p : surface.profile)
    if (p.x > kFlank * surface.largest_radius()) flank.push_back(p);
  if (flank.size() < kFewestOnFlank) return std::nullopt;
  Circle circle = circle_through(flank);
  std::span<Vec2d> near = flank;
  for (int round = 0; round < kBallRounds; ++round) {
    std::ranges::stable_sort(flank, {}, [&](const Vec2d& p) { return distance(circle, p); });
    near = std::span(flank).first(3 * flank.size() / 4);
    circle = circle_through(near);
  }
  double off = 0;
  for (const Vec2d& p : near) off += distance(circle, p);
  if (!(circle.radius > 0) || !(off <= kRound * circle.radius * double(near.size()))) return std::nullopt;
  return circle;
}

// Median IoU over the photos.
double agreement(std::span<const Silhouette> silhouettes, const SurfaceOfRevolution& surface) {
  std::vector<double> of(silhouettes.size(), -1);
  parallel_for(silhouettes.size(), 1, [&](size_t v) {
    const Silhouette& s = silhouettes[v];
    const std::vector<uint8_t> shown = silhouette_mask(surface, s.view);
    double both = 0, either = 0, marked = 0;
    for (size_t i = 0; i < shown.size(); ++i) {
      const float value = s.value.data()[i];
      if (value < 0) continue;
      const bool inside = value >= 0.5f;
      both += inside && shown[i], either += inside || shown[i], marked += inside;
    }
    if (marked >= kFewestPixels) of[v] = both / either;
  });
  std::erase(of, -1.0);
  return of.empty() ? 0 : quantile_of(of, 0.5);
}

}  // namespace

std::optional<SurfaceOfRevolution> ball_of(std::span<const Silhouette> silhouettes, const SurfaceOfRevolution& surface) {
  const std::optional<Circle> circle = circle_of_flank(surface);
  if (!circle) return std::nullopt;
  SurfaceOfRevolution ball{surface.origin, surface.axis, {}};
  for (size_t i = 0; i <= kSegments; ++i) {
    const double a = std::numbers::pi * double(i) / kSegments;
    const bool pole = i == 0 || i == kSegments;
    ball.profile.push_back({pole ? 0 : circle->radius * std::sin(a), circle->height - circle->radius * std::cos(a)});
  }
  const double as_ball = agreement(silhouettes, ball);
  if (as_ball < kBallAgreement || as_ball < agreement(silhouettes, surface) - kAsGood) return std::nullopt;
  return ball;
}

}  // namespace vitrine
