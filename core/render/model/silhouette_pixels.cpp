#include "core/render/model/silhouette_pixels.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"
#include "core/render/model/picture_window.h"

namespace vitrine {

namespace {

constexpr double kBetween_rel = 0.01;     // of its extent: maximum distance by which a shape exceeds its outer points
constexpr double kSilhouetteNear = 1e-3;  // z-depth; closer points are not projected
constexpr int kGrow = 2;                  // pixels; the silhouette's direction is estimated from the hits within this distance
constexpr double kEdgeReach = 2;          // pixels along that direction that must contain the edge
constexpr double kSideOffset = 0.75;      // pixels to either side, between which the edge is straight
constexpr int kHalvings = 10;             // bisection steps of kEdgeReach: the edge is accurate to 1/500 pixel

// Screen bounds of surface points; none if one is behind the camera or all are outside the picture.
class Extent {
 public:
  explicit Extent(const View& view) : view_(view) {}
  void add(const Vec3d& place) {
    const auto p = projection(place, view_, kSilhouetteNear);
    behind_ |= !p;
    if (behind_) return;
    const double at[2] = {p->x, p->y};
    for (size_t c = 0; c < 2; ++c) low_[c] = std::min(low_[c], at[c]), high_[c] = std::max(high_[c], at[c]);
  }
  std::optional<PictureWindow> window() const {
    if (behind_) return std::nullopt;
    const double more = kSilhouetteBand + kGrow + 2 + kBetween_rel * std::max(high_[0] - low_[0], high_[1] - low_[1]);
    const auto within = [](double x, int end) { return static_cast<int>(std::clamp(x, 0.0, double(end))); };
    const Intrinsics& k = view_.intrinsics;
    const PictureWindow w{within(low_[0] - more, k.width), within(low_[1] - more, k.height), within(high_[0] + more, k.width),
                          within(high_[1] + more, k.height)};
    if (w.empty()) return std::nullopt;
    return w;
  }

 private:
  const View& view_;
  bool behind_ = false;
  double low_[2] = {1e300, 1e300}, high_[2] = {-1e300, -1e300};
};

std::optional<PictureWindow> window_of(const Shape& shape, const View& view) {
  Extent extent(view);
  for (const Vec3d& p : outer_points(shape)) extent.add(p);
  return extent.window();
}

// Merges overlapping windows.
std::vector<PictureWindow> merged(std::vector<PictureWindow> windows) {
  for (size_t i = 0; i < windows.size(); ++i)
    for (size_t j = 0; j < windows.size(); ++j) {
      if (j == i) continue;
      PictureWindow &a = windows[i], &b = windows[j];
      if (!a.meets(b)) continue;
      a.extend(b);
      windows.erase(windows.begin() + ptrdiff_t(j));
      return merged(std::move(windows));  // the merged window may overlap earlier ones
    }
  return windows;
}

class WindowSilhouette {
 public:
  // `has_silhouette`: [entry] 0 if it reaches behind the camera and so has no silhouette; it still occludes.
  WindowSilhouette(const ShapeSet& set, const std::vector<uint8_t>& has_silhouette, const View& view, const PictureWindow& window)
      : set_(set), silhouetted_(has_silhouette), view_(view), window_(window), eye_(view.centre_in_world()) {}

  std::vector<SilhouettePixel> pixels();

 private:
  using Met = ShapeSet::Hit;
  struct End {
    double distance;
    Met met;  // of the last ray with a hit
  };
  size_t at(int x, int y) const { return static_cast<size_t>(y * window_.width() + x); }
  // Ray through window coordinates, with pixel centres at .5.
  Vec3d ray(double x, double y) const { return view_.ray(window_.left + x, window_.top + y); }
  std::optional<Met> met(double x, double y) const { return set_.first_hit({eye_, ray(x, y)}, ShapeRole::Mirror); }
  std::optional<End> end_along(double x, double y, const Vec2d& out) const;
  bool hit(int x, int y) const { return met_[at(x, y)].has_value(); }
  bool next_to_edge(int x, int y) const;
  std::optional<SilhouettePixel> crossed(int x, int y) const;

  const ShapeSet& set_;
  const std::vector<uint8_t>& silhouetted_;
  const View& view_;
  const PictureWindow window_;
  const Vec3d eye_;
  std::vector<std::optional<Met>> met_;  // [window] at the pixel centres
};

bool WindowSilhouette::next_to_edge(int x, int y) const {
  const bool own = hit(x, y);
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, window_.height() - 1); ++v)
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, window_.width() - 1); ++u)
      if (hit(u, v) != own) return true;
  return false;
}

// Distance along `out` from window coordinates (x, y) to the end of the shape, within kEdgeReach either way.
std::optional<WindowSilhouette::End> WindowSilhouette::end_along(double x, double y, const Vec2d& out) const {
  const auto at_distance = [&](double d) { return met(x + d * out.x, y + d * out.y); };
  auto here = at_distance(0);
  double inside = here ? 0 : -kEdgeReach, outside = here ? kEdgeReach : 0;
  auto last = here ? here : at_distance(inside);
  if (!last || (here && at_distance(outside))) return std::nullopt;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    if (const auto m = at_distance(middle))
      inside = middle, last = m;
    else
      outside = middle;
  }
  return End{inside, *last};
}

// Fits a straight edge through the pixel; none if its neighbourhood does not determine a direction or has more than one edge.
std::optional<SilhouettePixel> WindowSilhouette::crossed(int x, int y) const {
  Vec2d inwards{};
  for (int v = std::max(y - kGrow, 0); v <= std::min(y + kGrow, window_.height() - 1); ++v)
    for (int u = std::max(x - kGrow, 0); u <= std::min(x + kGrow, window_.width() - 1); ++u)
      if (hit(u, v)) inwards.x += u - x, inwards.y += v - y;
  const double size = std::hypot(inwards.x, inwards.y);
  if (!(size > 0)) return std::nullopt;
  Vec2d out{-inwards.x / size, -inwards.y / size};
  // The pixel count gives a coarse direction; the edge positions on either side of the pixel centre refine it.
  const double mx = x + 0.5, my = y + 0.5;
  const auto left = end_along(mx - kSideOffset * out.y, my + kSideOffset * out.x, out),
             right = end_along(mx + kSideOffset * out.y, my - kSideOffset * out.x, out);
  if (left && right) {
    const double slope = (left->distance - right->distance) / (2 * kSideOffset), l = std::hypot(1.0, slope);
    out = {(out.x + slope * out.y) / l, (out.y - slope * out.x) / l};
  }
  const auto end = end_along(mx, my, out);
  if (!end) return std::nullopt;
  const double inside = end->distance;
  const Met& last = end->met;
  if (!silhouetted_[last.entry]) return std::nullopt;
  const EdgeInPixel<double> edge = edge_in_pixel(inside, out);
  if (!(edge.covered > 0) || !(edge.covered < 1)) return std::nullopt;
  SilhouettePixel p{.entry = last.entry, .covered = static_cast<float>(edge.covered), .crossed = true, .edge = last};
  p.place = eye_ + last.t * ray(mx + inside * out.x, my + inside * out.y);
  const Vec3d in_camera = view_.cam_from_world * p.place;
  const Intrinsics& k = view_.intrinsics;
  const double gx = out.x * k.fx / in_camera.z, gy = out.y * k.fy / in_camera.z;
  p.grows = edge.length *
            transposed_times(view_.cam_from_world.rotation, Vec3d{gx, gy, -(gx * in_camera.x + gy * in_camera.y) / in_camera.z});
  // Centre of the covered area, half way from the edge to the pixel border.
  const double far_side = -0.5 * (std::abs(out.x) + std::abs(out.y)), middle = 0.5 * (inside + far_side);
  const auto shown = met(mx + middle * out.x, my + middle * out.y);
  p.z = static_cast<float>(shown ? shown->t : last.t);
  p.normal = cast<float>(shown ? shown->normal : last.normal);
  return p;
}

std::vector<SilhouettePixel> WindowSilhouette::pixels() {
  const int width = window_.width(), height = window_.height();
  const auto count = static_cast<size_t>(width) * static_cast<size_t>(height);
  met_.assign(count, std::nullopt);
  parallel_for(static_cast<size_t>(height), 4, [&](size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) met_[at(x, y)] = met(x + 0.5, y + 0.5);
  });
  std::vector<std::vector<std::pair<size_t, SilhouettePixel>>> rows(static_cast<size_t>(height));
  parallel_for(rows.size(), 4, [&](size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x)
      if (next_to_edge(x, y))
        if (auto p = crossed(x, y)) rows[row].emplace_back(at(x, y), *p);
  });
  // The band: each pixel takes the nearest crossed pixel.
  std::vector<float> nearest(count, 1e9f);
  std::vector<uint32_t> own(count, UINT32_MAX), nearest_edge(count, UINT32_MAX);
  std::vector<SilhouettePixel> edge;
  for (const auto& row : rows)
    for (const auto& [where, p] : row) {
      own[where] = static_cast<uint32_t>(edge.size());
      edge.push_back(p);
      const int x = static_cast<int>(where) % width, y = static_cast<int>(where) / width;
      for (int v = std::max(y - kSilhouetteBand, 0); v <= std::min(y + kSilhouetteBand, height - 1); ++v)
        for (int u = std::max(x - kSilhouetteBand, 0); u <= std::min(x + kSilhouetteBand, width - 1); ++u) {
          const auto away = static_cast<float>((u - x) * (u - x) + (v - y) * (v - y));
          if (away >= nearest[at(u, v)] || away > float(kSilhouetteBand * kSilhouetteBand)) continue;
          nearest[at(u, v)] = away, nearest_edge[at(u, v)] = own[where];
        }
    }
  std::vector<SilhouettePixel> out;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const size_t i = at(x, y);
      if (nearest_edge[i] == UINT32_MAX || (met_[i] && !silhouetted_[met_[i]->entry])) continue;
      SilhouettePixel p = edge[nearest_edge[i]];
      if (own[i] == UINT32_MAX) p = {.entry = p.entry, .covered = met_[i] ? 1.f : 0.f, .z = p.z, .away = std::sqrt(nearest[i])};
      p.pixel = static_cast<uint32_t>((window_.top + y) * view_.intrinsics.width + window_.left + x);
      if (!p.crossed && met_[i]) {
        p.entry = met_[i]->entry;
        p.z = static_cast<float>(met_[i]->t);
        p.normal = cast<float>(met_[i]->normal);
      }
      out.push_back(p);
    }
  return out;
}

}  // namespace

std::vector<SilhouettePixel> silhouette_pixels(const ShapeSet& set, const View& view) {
  std::vector<PictureWindow> windows;
  std::vector<uint8_t> has_silhouette(set.entries.size(), 0);
  for (size_t k = 0; k < has_silhouette.size(); ++k) {
    if (set.entries[k].role != ShapeRole::Mirror) continue;
    if (const auto window = window_of(set.entries[k].shape, view)) windows.push_back(*window), has_silhouette[k] = 1;
  }
  std::vector<SilhouettePixel> out;
  for (const PictureWindow& window : merged(std::move(windows))) {
    const std::vector<SilhouettePixel> in_window = WindowSilhouette(set, has_silhouette, view, window).pixels();
    out.insert(out.end(), in_window.begin(), in_window.end());
  }
  std::ranges::sort(out, {}, &SilhouettePixel::pixel);
  return out;
}

void silhouette_vjp(const SilhouettePixel& at, const Shape& shape, double grad_covered, std::span<double> grad) {
  place_vjp(shape, at.edge, at.place, grad_covered * at.grows, grad);
}

}  // namespace vitrine
