#include "pipeline/report_page/regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "core/foundation/math/color.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/camera/view.h"
#include "pipeline/report_page/page.h"

namespace vitrine {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kWidth = 520, kMargin = 14, kFrustum = 9;  // SVG units
constexpr size_t kMostPoints = 3000;
constexpr double kMinSpread = 0.006;  // minimum spread of positions; below it the cameras look along the scene

// Projection plane of a drawing: world -> (right, up).
struct Plane {
  Vec3d right, up;
  Vec2d operator()(const Vec3d& p) const { return {dot(right, p), dot(up, p)}; }
};

struct Range {
  double low = 0, high = 0;
  double size() const { return high - low; }
};

// Range of all cameras and of the points without outliers.
Range range_of(std::vector<double> cameras, std::vector<double> points) {
  constexpr double kOutliers = 0.03;
  Range r{*std::min_element(cameras.begin(), cameras.end()), *std::max_element(cameras.begin(), cameras.end())};
  if (!points.empty()) {
    const size_t cut = size_t(kOutliers * double(points.size()));
    r.low = std::min(r.low, order_statistic_of(std::span(points), cut));
    r.high = std::max(r.high, order_statistic_of(std::span(points), points.size() - 1 - cut));
  }
  if (r.size() < 1e-6) r.low -= 0.5, r.high += 0.5;
  return r;
}

class Drawing {
 public:
  Drawing(const ViewSet& views, const Plane& plane) : views_(views), plane_(plane) {
    std::vector<double> cx, cy, px, py;
    for (const View& v : views.views) {
      const Vec2d c = plane(v.centre_in_world());
      cx.push_back(c.x), cy.push_back(c.y);
    }
    for (const ScenePoint& p : views.points) {
      const Vec2d q = plane(p.position);
      px.push_back(q.x), py.push_back(q.y);
    }
    x_ = range_of(cx, px);
    y_ = range_of(cy, py);
    scale_ = (kWidth - 2 * kMargin) / std::max(x_.size(), y_.size());
    height_ = std::max(y_.size() * scale_ + 2 * kMargin, kWidth / 4);
  }

  std::string svg(const std::set<std::string>& heldout, const std::string& title, const std::string& extra) const {
    return fmt::format("<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">", kWidth, height_, escaped(title)) +
           points() + extra + cameras(heldout) + "</svg>";
  }
  Vec2d at(const Vec3d& p) const {
    const Vec2d q = plane_(p);
    return {kWidth / 2 + (q.x - 0.5 * (x_.low + x_.high)) * scale_, height_ / 2 - (q.y - 0.5 * (y_.low + y_.high)) * scale_};
  }
  double scale() const { return scale_; }

 private:
  // One SVG path per colour, quantised to four steps per channel; a dot is a zero-length line with round caps.
  std::string points() const {
    const size_t stride = std::max<size_t>(1, (views_.points.size() + kMostPoints - 1) / kMostPoints);
    std::map<int, std::string> paths;
    for (size_t i = 0; i < views_.points.size(); i += stride) {
      const Vec2d q = at(views_.points[i].position);
      if (!(q.x >= 0 && q.x <= kWidth && q.y >= 0 && q.y <= height_)) continue;
      int colour = 0;
      for (size_t c = 0; c < 3; ++c)
        colour = colour * 4 + std::clamp(int(srgb_from_linear(views_.points[i].linear_rgb[c]) * 4), 0, 3);
      paths[colour] += fmt::format("M{:.0f} {:.0f}h0", q.x, q.y);
    }
    std::string out = "<g class=\"points\">";
    for (const auto& [colour, path] : paths)
      out += fmt::format("<path stroke=\"rgb({},{},{})\" d=\"{}\"/>", 32 + 64 * (colour / 16), 32 + 64 * (colour / 4 % 4),
                         32 + 64 * (colour % 4), path);
    return out + "</g>";
  }

  // Gives all faces the same orientation, so that overlapping faces do not cut holes (non-zero fill rule).
  static std::string closed(std::vector<Vec2d> corners) {
    double area = 0;
    for (size_t i = 0; i < corners.size(); ++i) {
      const Vec2d &p = corners[i], &q = corners[(i + 1) % corners.size()];
      area += p.x * q.y - p.y * q.x;
    }
    if (area < 0) std::reverse(corners.begin(), corners.end());
    std::string path;
    for (const Vec2d& p : corners) path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', p.x, p.y);
    return path + "Z";
  }

  std::string cameras(const std::set<std::string>& heldout) const {
    std::string out = "<g class=\"cameras\">";
    for (const View& v : views_.views) {
      // The frustum has constant size in the drawing and is projected correctly, also along the view direction.
      const Vec3d centre = v.centre_in_world();
      const auto corner = [&](double x, double y) {
        return at(centre + (kFrustum / scale_) * (transposed(v.cam_from_world.rotation) * Vec3d{0.55 * x, 0.42 * y, 1}));
      };
      const Vec2d tip = at(centre), a = corner(-1, -1), b = corner(1, -1), c = corner(1, 1), d = corner(-1, 1);
      const bool held = heldout.contains(v.name);
      std::string path = closed({a, b, c, d});
      for (const auto& [p, q] : {std::pair(a, b), std::pair(b, c), std::pair(c, d), std::pair(d, a)}) path += closed({tip, p, q});
      out += fmt::format("<path{} d=\"{}\"><title>{}{}</title></path>", held ? " class=\"heldout\"" : "", path, escaped(v.name),
                         held ? " (held out)" : "");
    }
    return out + "</g>";
  }

  const ViewSet& views_;
  Plane plane_;
  Range x_, y_;
  double scale_ = 1, height_ = 0;
};

}  // namespace

namespace {

std::optional<Vec3d> centre_of(const ViewSet& set) {
  if (set.views.size() < 3) return std::nullopt;
  const LookedAt found = looked_at(set.views);
  return found.spread < kMinSpread ? std::nullopt : std::optional(found.point);
}

}  // namespace

std::optional<RingCoverage> ring_coverage(const ViewSet& views) {
  const auto centre = centre_of(views);
  if (!centre) return std::nullopt;
  std::vector<double> azimuths;
  RingCoverage r{.lowest_deg = 90, .highest_deg = -90};
  for (const View& v : views.views) {
    const Vec3d d = v.centre_in_world() - *centre;
    azimuths.push_back(std::atan2(d.y, d.x) * kDegrees);
    const double elevation = std::atan2(d.z, std::hypot(d.x, d.y)) * kDegrees;
    r.lowest_deg = std::min(r.lowest_deg, elevation);
    r.highest_deg = std::max(r.highest_deg, elevation);
  }
  std::sort(azimuths.begin(), azimuths.end());
  for (size_t i = 0; i < azimuths.size(); ++i) {
    const bool last = i + 1 == azimuths.size();
    const double gap = (last ? azimuths[0] + 360 : azimuths[i + 1]) - azimuths[i];
    if (gap > r.gap_deg) r.gap_deg = gap, r.gap_from_deg = azimuths[i];
  }
  return r;
}

std::string plan_svg(const ViewSet& views, const std::set<std::string>& heldout) {
  if (views.views.empty()) return {};
  const Drawing drawing(views, {.right = {1, 0, 0}, .up = {0, 1, 0}});
  std::string gap;
  const auto ring = ring_coverage(views);
  const auto centre = centre_of(views);
  if (ring && ring->gap_deg >= kGapDrawnDeg) {
    double radius = 0;
    for (const View& v : views.views) {
      const Vec3d d = v.centre_in_world() - *centre;
      radius += 0.5 * std::hypot(d.x, d.y) / double(views.views.size());  // half the mean camera distance: inside the drawing
    }
    const auto on_ring = [&](double degrees) {
      return drawing.at(*centre + radius * Vec3d{std::cos(degrees / kDegrees), std::sin(degrees / kDegrees), 0});
    };
    const Vec2d from = on_ring(ring->gap_from_deg), to = on_ring(ring->gap_from_deg + ring->gap_deg);
    gap = fmt::format("<path class=\"gap\" d=\"M{:.1f} {:.1f}A{:.1f} {:.1f} 0 {} 0 {:.1f} {:.1f}\"/>", from.x, from.y,
                      radius * drawing.scale(), radius * drawing.scale(), ring->gap_deg > 180 ? 1 : 0, to.x, to.y);
  }
  return drawing.svg(heldout, fmt::format("Plan: {} cameras and the sparse points from above", views.views.size()), gap);
}

std::string elevation_svg(const ViewSet& views, const std::set<std::string>& heldout) {
  if (views.views.empty()) return {};
  const Drawing drawing(views, {.right = {1, 0, 0}, .up = {0, 0, 1}});
  return drawing.svg(heldout, fmt::format("Elevation: {} cameras and the sparse points from the front", views.views.size()), "");
}

}  // namespace vitrine
