#include "stages/masks/proposed/proposed_source.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/log.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {

namespace {

constexpr double kCaseReach = 0.6;           // of the radius of the camera ring: no search beyond
constexpr double kLow = 0.02, kHigh = 0.98;  // of the sparse points
constexpr double kAboveCameras = 0.3;        // of the ring: minimum height of the search region above the cameras
constexpr size_t kFewestPoints = 20;
constexpr double kOnSurface = 0.03;        // of the depth
constexpr double kFoot = 0.15;             // share of known points in the footprint of a box that lie below its bottom
constexpr double kShrunk = 0.8;            // of the footprint: excludes neighbouring objects
constexpr double kBelow = 0.5;             // of the height: the bottom may lie this far below the lower end of the edges
constexpr size_t kFewestCasePixels = 300;  // over all photos: minimum to judge a side or a bottom
constexpr size_t kMostTested = 12;         // maximum number of tested boxes
constexpr double kLeastRim = 5.5;          // standard deviations of the edge score of the rim above that of other heights
constexpr double kLeastSeenThrough = 0.6;  // minimum per side: share of known pixels whose surface lies behind the side

// visit(pixel, reliable z-depth or 0, crossing of the pixel's ray with the box, eye, ray)
template <class Visit>
void for_each_pixel(const Box& box, const View& view, const DepthMap& map, const Visit& visit) {
  const Intrinsics& k = view.intrinsics;
  const Vec3d eye = view.centre_in_world();
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const Vec3d ray = view.ray(x + 0.5, y + 0.5);
      const size_t pixel = k.index(x, y);
      const bool known = !map.trusted.empty() && map.reliable(pixel);
      visit(pixel, known ? double(map.zdepth[pixel]) : 0.0, box.crossing(eye, ray), eye, ray);
    }
}

bool same_place(const Box& a, const Box& b) {
  const auto holds = [](const Box& box, const Box& other) {
    const Vec3d middle = transposed_times(box.axes, other.axes * (0.5 * (other.low + other.high)));
    return middle.x > box.low.x && middle.x < box.high.x && middle.y > box.low.y && middle.y < box.high.y;
  };
  return holds(a, b) || holds(b, a);
}

// Bottom of a case: the surface below it, except for a few outliers.
double foot(const Box& box, std::span<const View> views, std::span<const DepthMap> maps) {
  Box column = box;
  const Vec3d middle = 0.5 * (box.low + box.high);
  for (size_t axis = 0; axis < 2; ++axis) {
    column.low[axis] = middle[axis] + kShrunk * (box.low[axis] - middle[axis]);
    column.high[axis] = middle[axis] + kShrunk * (box.high[axis] - middle[axis]);
  }
  column.low.z -= kBelow * (box.high.z - box.low.z);
  std::vector<double> heights;
  for (size_t v = 0; v < views.size(); ++v)
    for_each_pixel(column, views[v], maps[v], [&](size_t, double z, const auto& crossing, const Vec3d& eye, const Vec3d& ray) {
      if (crossing && z > crossing->in && z < crossing->out) heights.push_back(transposed_times(box.axes, eye + z * ray).z);
    });
  if (heights.size() < kFewestCasePixels) return box.low.z;
  return order_statistic_of(std::span(heights), size_t(kFoot * double(heights.size())));
}

// Share of the known pixels of a side whose surface lies behind it; minimum over the sides with enough pixels.
double seen_through(const Box& box, std::span<const View> views, std::span<const DepthMap> maps) {
  std::array<size_t, Box::kFaces> all{}, through{};
  for (size_t v = 0; v < views.size(); ++v)
    for_each_pixel(box, views[v], maps[v], [&](size_t, double z, const auto& crossing, const Vec3d&, const Vec3d&) {
      if (!crossing || !(z > 0) || z < (1 - kOnSurface) * crossing->in) return;
      ++all[crossing->entered.index()];
      through[crossing->entered.index()] += z > (1 + kOnSurface) * crossing->in;
    });
  double least = 1;
  bool any = false;
  for (size_t f = 0; f < all.size(); ++f) {
    if (all[f] < kFewestCasePixels) continue;
    least = std::min(least, double(through[f]) / double(all[f]));
    any = true;
  }
  return any ? least : 0;
}

}  // namespace

Bounds3 about_standing_boxes(const ViewSet& set) {
  std::vector<double> heights;
  for (const ScenePoint& p : set.points)
    if (std::hypot(p.position.x, p.position.y) < 1) heights.push_back(p.position.z);
  if (heights.size() < kFewestPoints) return {};
  const double low = quantile_of(heights, kLow), high = quantile_of(heights, kHigh);
  return {{-kCaseReach, -kCaseReach, low}, {kCaseReach, kCaseReach, std::max(high, kAboveCameras)}};
}

std::vector<DisplayCase> display_cases(std::span<const StandingBox> boxes, std::span<const View> views,
                                       std::span<const DepthMap> maps) {
  std::vector<DisplayCase> found;
  size_t tested = 0;
  for (const StandingBox& standing : boxes) {
    if (standing.rim < kLeastRim) continue;
    if (std::ranges::any_of(found, [&](const DisplayCase& f) { return same_place(f.box, standing.box); })) continue;
    if (++tested > kMostTested) break;
    DisplayCase glass{standing.box, standing.posts, standing.rim, 0};
    glass.box.low.z = foot(glass.box, views, maps);
    if (glass.box.high.z > glass.box.low.z) glass.seen_through = seen_through(glass.box, views, maps);
    const bool is_glass = glass.seen_through >= kLeastSeenThrough;
    const Vec3d c = glass.box.axes * (0.5 * (glass.box.low + glass.box.high)), e = glass.box.high - glass.box.low;
    const std::string place = fmt::format("{:.2f} x {:.2f} x {:.2f} at ({:.2f} {:.2f} {:.2f})", e.x, e.y, e.z, c.x, c.y, c.z);
    if (is_glass)
      log_info(
          "masks: a glass case of {}, found by its edges (masks/contact_sheet.png shows it; "
          "--set masks.proposed.display_case.look=false if it is none)",
          place);
    log_debug("masks: a box of {}: upright edges {:.1f}, rim {:.1f}, every side seen through at {:.0f} % of its pixels", place,
              glass.posts, glass.rim, 100 * glass.seen_through);
    if (is_glass) found.push_back(glass);
  }
  return found;
}

std::vector<uint8_t> case_mask(const DisplayCase& glass, const View& view, const DepthMap& map) {
  std::vector<uint8_t> mask(view.intrinsics.pixel_count(), 0);
  for_each_pixel(glass.box, view, map, [&](size_t pixel, double z, const auto& crossing, const Vec3d&, const Vec3d&) {
    mask[pixel] = crossing && !(z > 0 && z < (1 - kOnSurface) * crossing->in);
  });
  return mask;
}

}  // namespace vitrine
