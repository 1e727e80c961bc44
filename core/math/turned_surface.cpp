#include "core/math/turned_surface.h"

#include <algorithm>
#include <cmath>

namespace vitrine {

namespace {

constexpr double kLevel = 1e-9;  // rise of a line in its length: below, it is a ring and not a cone

// Ray and axis: of a point of the ray, the way from the axis squared is c + 2 b t + a t^2, the height h + climb t.
struct AboutAxis {
  double a, b, c, h, climb;
  AboutAxis(const TurnedSurface& s, const Vec3d& eye, const Vec3d& direction) {
    const Vec3d from = eye - s.origin;
    h = dot(from, s.axis), climb = dot(direction, s.axis);
    const Vec3d across = from - h * s.axis, move = direction - climb * s.axis;
    a = dot(move, move), b = dot(across, move), c = dot(across, across);
  }
};

// Goes in at t through the line p..q: it is there, and the ray runs against its normal.
bool goes_in(const AboutAxis& ray, const Vec2d& p, const Vec2d& q, double t) {
  if (!(t > 0)) return false;
  const double rho = std::sqrt(std::max(ray.c + t * (2 * ray.b + t * ray.a), 0.0)), h = ray.h + t * ray.climb;
  const double dx = q.x - p.x, dy = q.y - p.y;
  const double along = (rho - p.x) * dx + (h - p.y) * dy;
  if (along < 0 || along > dx * dx + dy * dy) return false;
  const double widens = rho > 0 ? (ray.b + t * ray.a) / rho : 0;
  return dy * widens - dx * ray.climb < 0;
}

}  // namespace

double TurnedSurface::largest_radius() const {
  double largest = 0;
  for (const Vec2d& p : profile) largest = std::max(largest, p.x);
  return largest;
}

std::vector<Vec2d> TurnedSurface::line_normals() const {
  std::vector<Vec2d> out;
  for (size_t i = 0; i + 1 < profile.size(); ++i) {
    const double dx = profile[i + 1].x - profile[i].x, dy = profile[i + 1].y - profile[i].y, l = std::hypot(dx, dy);
    out.push_back(l > 0 ? Vec2d{dy / l, -dx / l} : Vec2d{1, 0});
  }
  return out;
}

std::vector<Vec2d> TurnedSurface::corner_normals() const {
  const std::vector<Vec2d> lines = line_normals();
  std::vector<Vec2d> out(profile.size());
  for (size_t i = 0; i < lines.size(); ++i)
    for (size_t corner : {i, i + 1}) out[corner].x += lines[i].x, out[corner].y += lines[i].y;
  return out;
}

std::optional<TurnedSurface::Entry> TurnedSurface::entry(const Vec3d& eye, const Vec3d& direction) const {
  const AboutAxis ray(*this, eye, direction);
  // The ray comes no nearer to the axis than this: most lines are out of its reach at once.
  const double nearest = ray.a > 0 ? std::sqrt(std::max(ray.c - ray.b * ray.b / ray.a, 0.0)) * (1 - kLevel) : 0;
  std::optional<Entry> first;
  for (size_t i = 0; i + 1 < profile.size(); ++i) {
    const Vec2d &p = profile[i], &q = profile[i + 1];
    if (p.x < nearest && q.x < nearest) continue;
    const double dx = q.x - p.x, dy = q.y - p.y;
    const auto consider = [&](double t) {
      if ((!first || t < first->t) && goes_in(ray, p, q, t)) first = Entry{t, i};
    };
    if (std::abs(dy) < kLevel * std::abs(dx)) {
      if (ray.climb != 0) consider((p.y - ray.h) / ray.climb);
      continue;
    }
    // The radius of the cone is linear in t as well.
    const double widen = dx / dy, radius = p.x + widen * (ray.h - p.y), growth = widen * ray.climb;
    const double a = ray.a - growth * growth, b = ray.b - radius * growth, c = ray.c - radius * radius;
    const double discriminant = b * b - a * c;
    if (discriminant < 0) continue;
    const double k = -(b + std::copysign(std::sqrt(discriminant), b));  // roots without cancellation
    for (const double root : {a != 0 ? k / a : -1, k != 0 ? c / k : -1})
      if (radius + growth * root >= 0) consider(root);  // else of the cone's other half, beyond its tip
  }
  return first;
}

TurnedSurface::Place TurnedSurface::nearest(const Vec3d& p) const {
  const Vec3d from = p - origin;
  const double h = dot(from, axis);
  const Vec3d across = from - h * axis;
  const double r = length(across);
  const Vec3d out = r > 0 ? across / r : normalized(cross(axis, std::abs(axis.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
  const std::vector<Vec2d> normals = corner_normals();
  double best = 1e300;
  Vec2d at{}, normal{};
  for (size_t i = 0; i + 1 < profile.size(); ++i) {
    const Vec2d &a = profile[i], &b = profile[i + 1];
    const double dx = b.x - a.x, dy = b.y - a.y, squared = dx * dx + dy * dy;
    const double w = squared > 0 ? std::clamp(((r - a.x) * dx + (h - a.y) * dy) / squared, 0.0, 1.0) : 0;
    const Vec2d q{a.x + w * dx, a.y + w * dy};
    const double distance = std::hypot(r - q.x, h - q.y);
    if (distance >= best) continue;
    best = distance, at = q;
    normal = {(1 - w) * normals[i].x + w * normals[i + 1].x, (1 - w) * normals[i].y + w * normals[i + 1].y};
  }
  return {origin + at.y * axis + at.x * out, normalized(normal.x * out + normal.y * axis)};
}

void corner_normals_vjp(const TurnedSurface& surface, const std::vector<Vec2d>& grad_normals, std::vector<Vec2d>& grad_profile) {
  for (size_t i = 0; i + 1 < surface.profile.size(); ++i) {
    const Vec2d &p = surface.profile[i], &q = surface.profile[i + 1];
    const double dx = q.x - p.x, dy = q.y - p.y, l = std::hypot(dx, dy);
    if (!(l > 0)) continue;
    // n = (dy, -dx) / l
    const double gx = grad_normals[i].x + grad_normals[i + 1].x, gy = grad_normals[i].y + grad_normals[i + 1].y;
    const double along = (gx * dy - gy * dx) / (l * l);
    const double grad_dy = (gx - along * dy) / l, grad_dx = -(gy + along * dx) / l;
    grad_profile[i + 1].x += grad_dx, grad_profile[i + 1].y += grad_dy;
    grad_profile[i].x -= grad_dx, grad_profile[i].y -= grad_dy;
  }
}

TurnedSurface with_equal_lines(const TurnedSurface& surface, size_t count) {
  const auto& p = surface.profile;
  std::vector<double> way(p.size(), 0.0);
  for (size_t i = 1; i < p.size(); ++i) way[i] = way[i - 1] + std::hypot(p[i].x - p[i - 1].x, p[i].y - p[i - 1].y);
  TurnedSurface out{surface.origin, surface.axis, {}};
  size_t i = 0;
  for (size_t k = 0; k <= count; ++k) {
    const double at = way.back() * double(k) / double(count);
    while (i + 2 < p.size() && way[i + 1] < at) ++i;
    const double length = way[i + 1] - way[i], u = length > 0 ? std::clamp((at - way[i]) / length, 0.0, 1.0) : 0;
    out.profile.push_back({(1 - u) * p[i].x + u * p[i + 1].x, (1 - u) * p[i].y + u * p[i + 1].y});
  }
  return out;
}

}  // namespace vitrine
