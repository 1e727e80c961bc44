#include <algorithm>
#include <cmath>

#include "core/observe/stereo/plane_fit.h"
#include "core/observe/stereo/plane_silhouette.h"
#include "core/observe/stereo/silhouette.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

constexpr size_t kMostOutlines = 60;   // largest quadrilaterals, all pairs of which are tried
constexpr double kLeastAngle = 0.1;    // radians: minimum angle between two intersecting rays
constexpr double kMostGap_px = 0.012;  // maximum distance between two rays, of the picture's longest side
constexpr double kSquare = 0.25;       // maximum cosine between the sides of a rectangle: rays at small angles are inaccurate
constexpr double kFlat_rel = 0.2;      // of its size: maximum deviation of the four points from a rectangle
constexpr double kOnCorner = 0.15;     // of the square root of a quadrilateral's area: tolerance for matching corners
constexpr size_t kFewestOutlines = 3;
constexpr size_t kMostOfOutlines = 12;  // candidates

struct Outline {
  const View* view;
  Quadrilateral shape;
  std::array<Vec3d, 4> rays;  // unit, in the world
  Vec3d eye;
};

std::vector<Outline> largest_outlines(std::span<const Silhouette> masks, double least_share) {
  std::vector<Outline> out;
  for (const Silhouette& mask : masks)
    for (const Quadrilateral& shape : quadrilaterals(mask, least_share)) {
      Outline outline{&mask.view, shape, {}, mask.view.centre_in_world()};
      for (size_t i = 0; i < 4; ++i) outline.rays[i] = normalized(mask.view.ray(shape.corners[i].x, shape.corners[i].y));
      out.push_back(outline);
    }
  std::stable_sort(out.begin(), out.end(), [](const Outline& a, const Outline& b) {
    return a.shape.area / (double(a.view->intrinsics.width) * a.view->intrinsics.height) >
           b.shape.area / (double(b.view->intrinsics.width) * b.view->intrinsics.height);
  });
  return out;
}

// Midpoint of the shortest segment between two rays.
std::optional<Vec3d> meeting(const Outline& a, const Vec3d& from_a, const Outline& b, const Vec3d& from_b) {
  const Vec3d between = b.eye - a.eye;
  const double c = dot(from_a, from_b), sine = 1 - c * c;
  if (sine < kLeastAngle * kLeastAngle) return std::nullopt;
  const double s = (dot(between, from_a) - c * dot(between, from_b)) / sine, t = c * s - dot(between, from_b);
  if (!(s > 0 && t > 0)) return std::nullopt;
  const Vec3d p = a.eye + s * from_a, q = b.eye + t * from_b;
  const double gap = length(p - q);
  for (const auto& [outline, depth] : {std::pair(&a, s), std::pair(&b, t)})
    if (gap * outline->view->intrinsics.fx > kMostGap_px * outline->view->intrinsics.longest_side() * depth) return std::nullopt;
  return 0.5 * (p + q);
}

// `corners`: clockwise as a camera sees them.
std::optional<Plane> rectangle(const std::array<Vec3d, 4>& p) {
  const Vec3d right = 0.25 * (p[1] - p[0] + p[2] - p[3]), down = 0.25 * (p[3] - p[0] + p[2] - p[1]);
  const double width = length(right), height = length(down);
  if (!(width > 0 && height > 0)) return std::nullopt;
  const Vec3d u = right / width, v = down / height;
  if (std::abs(dot(u, v)) > kSquare) return std::nullopt;
  const Vec3d middle = normalized(u + v), across = normalized(u - v);  // u and v rotated symmetrically to a right angle
  const Vec3d x = normalized(middle + across), up = -normalized(middle - across);
  const Plane out{0.25 * (p[0] + p[1] + p[2] + p[3]), Mat3d{x, up, cross(x, up)}, {width, height}};
  const std::array<Vec3d, 4> own = corners_of(out);
  for (size_t i = 0; i < 4; ++i)
    if (length(own[3 - i] - p[i]) > kFlat_rel * out.size()) return std::nullopt;
  return out;
}

struct Support {
  size_t outlines = 0;
  double off = 0;  // summed corner distance
};

Support support_of(const Plane& plane, std::span<const Outline> outlines) {
  Support out;
  const std::array<Vec3d, 4> corners = corners_of(plane);
  for (const Outline& outline : outlines) {
    if (!faces(plane, *outline.view)) continue;
    std::array<Vec2d, 4> at;
    bool in_front = true;
    for (size_t i = 0; i < 4 && in_front; ++i) {
      const auto p = projection(corners[3 - i], *outline.view, 1e-6);
      in_front = p.has_value();
      if (p) at[i] = {p->x, p->y};
    }
    if (!in_front) continue;
    double least = 1e300;
    for (size_t shift = 0; shift < 4; ++shift) {
      double most = 0;
      for (size_t i = 0; i < 4; ++i) {
        const Vec2d d = at[i] - outline.shape.corners[(i + shift) % 4];
        most = std::max(most, std::hypot(d.x, d.y));
      }
      least = std::min(least, most);
    }
    least /= std::sqrt(outline.shape.area);
    if (least < kOnCorner) ++out.outlines, out.off += least;
  }
  return out;
}

bool alike(const Plane& a, const Plane& b) {
  return length(a.centre - b.centre) < 0.1 * std::min(a.size(), b.size()) && dot(a.axes.c2, b.axes.c2) > 0.97 &&
         std::abs(a.size() - b.size()) < 0.1 * a.size();
}

}  // namespace

std::vector<Plane> candidates_of_outlines(std::span<const Silhouette> masks, double least_share) {
  struct Candidate {
    Plane plane;
    Support support;
  };
  const std::vector<Outline> outlines = largest_outlines(masks, least_share);
  std::vector<Candidate> found;
  for (size_t i = 0; i < std::min(outlines.size(), kMostOutlines); ++i)
    for (size_t j = i + 1; j < std::min(outlines.size(), kMostOutlines); ++j) {
      const Outline &a = outlines[i], &b = outlines[j];
      if (a.view == b.view) continue;
      for (size_t shift = 0; shift < 4; ++shift) {
        std::array<Vec3d, 4> corners;
        bool meet = true;
        for (size_t c = 0; c < 4 && meet; ++c) {
          const auto p = meeting(a, a.rays[c], b, b.rays[(c + shift) % 4]);
          meet = p.has_value();
          if (p) corners[c] = *p;
        }
        const auto plane = meet ? rectangle(corners) : std::nullopt;
        if (!plane) continue;
        const Support support = support_of(*plane, outlines);
        if (support.outlines >= kFewestOutlines) found.push_back({*plane, support});
      }
    }
  std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return a.support.outlines > b.support.outlines || (a.support.outlines == b.support.outlines && a.support.off < b.support.off);
  });
  std::vector<Plane> out;
  for (const Candidate& candidate : found)
    if (out.size() < kMostOfOutlines && std::ranges::none_of(out, [&](const Plane& p) { return alike(p, candidate.plane); }))
      out.push_back(candidate.plane);
  return out;
}

}  // namespace vitrine
