#include "core/scene/shape/surface_of_revolution.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/math/vec.h"
#include "core/scene/shape/kernels/revolution_point.h"

namespace vitrine {

namespace {

constexpr double kLevel = 1e-9;    // minimum ratio of height to length of a cone segment; below it is a flat ring
constexpr int kRingPoints = 24;    // of outer_points()
constexpr int kProfileMixing = 6;  // passes of the 1 2 1 filter over the profile gradient

Vec2d scaled(double s, const Vec2d& v) { return {s * v.x, s * v.y}; }
double dot2(const Vec2d& a, const Vec2d& b) { return a.x * b.x + a.y * b.y; }

// Ray relative to the axis: squared distance to the axis is c + 2 b t + a t^2, height is h + climb t.
struct AboutAxis {
  double a, b, c, h, climb;
  AboutAxis(const SurfaceOfRevolution& s, const Ray& ray) {
    const Vec3d from = ray.origin - s.origin;
    h = dot(from, s.axis), climb = dot(ray.direction, s.axis);
    const Vec3d across = from - h * s.axis, move = ray.direction - climb * s.axis;
    a = dot(move, move), b = dot(across, move), c = dot(across, across);
  }
};

// True if the ray enters at t through segment p..q: the hit is on the segment and the ray runs against its normal.
bool goes_in(const AboutAxis& ray, const Vec2d& p, const Vec2d& q, double t) {
  if (!(t > 0)) return false;
  const double rho = std::sqrt(std::max(ray.c + t * (2 * ray.b + t * ray.a), 0.0)), h = ray.h + t * ray.climb;
  const double dx = q.x - p.x, dy = q.y - p.y;
  const double along = (rho - p.x) * dx + (h - p.y) * dy;
  if (along < 0 || along > dx * dx + dy * dy) return false;
  const double widens = rho > 0 ? (ray.b + t * ray.a) / rho : 0;
  return dy * widens - dx * ray.climb < 0;
}

std::array<Vec3d, 2> across(const Vec3d& axis) {
  const auto [u, v] = orthonormal_basis(axis, 0);
  return {u, v};
}

ProfileSegment<double> segment(const SurfaceOfRevolution& s, size_t i) {
  return {s.origin, s.axis, s.profile[i], s.profile[i + 1], s.vertex_normal(i), s.vertex_normal(i + 1)};
}

// Backpropagates the gradient on a segment normal to its ends: n = (dy, -dx) / l.
void segment_normal_vjp(const SurfaceOfRevolution& s, size_t i, const Vec2d& g, std::span<Vec2d> ends, size_t first) {
  const double dx = s.profile[i + 1].x - s.profile[i].x, dy = s.profile[i + 1].y - s.profile[i].y, l = std::hypot(dx, dy);
  if (!(l > 0)) return;
  const double along = (g.x * dy - g.y * dx) / (l * l);
  const Vec2d d{-(g.y + along * dx) / l, (g.x - along * dy) / l};
  ends[i + 1 - first] = ends[i + 1 - first] + d, ends[i - first] = ends[i - first] - d;
}

}  // namespace

double SurfaceOfRevolution::largest_radius() const {
  double largest = 0;
  for (const Vec2d& p : profile) largest = std::max(largest, p.x);
  return largest;
}

Vec2d SurfaceOfRevolution::segment_normal(size_t i) const {
  const double dx = profile[i + 1].x - profile[i].x, dy = profile[i + 1].y - profile[i].y, l = std::hypot(dx, dy);
  return l > 0 ? Vec2d{dy / l, -dx / l} : Vec2d{1, 0};
}

Vec2d SurfaceOfRevolution::vertex_normal(size_t i) const {
  Vec2d sum{};
  if (i > 0) sum = sum + segment_normal(i - 1);
  if (i + 1 < profile.size()) sum = sum + segment_normal(i);
  return sum;
}

std::optional<ShapeHit> SurfaceOfRevolution::intersect(const Ray& r) const {
  const AboutAxis ray(*this, r);
  // Minimum distance of the ray to the axis: rejects most segments.
  const double nearest = ray.a > 0 ? std::sqrt(std::max(ray.c - ray.b * ray.b / ray.a, 0.0)) * (1 - kLevel) : 0;
  struct Entry {
    double t;
    size_t segment;
  };
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
    // The cone radius is linear in t as well.
    const double widen = dx / dy, radius = p.x + widen * (ray.h - p.y), growth = widen * ray.climb;
    const double a = ray.a - growth * growth, b = ray.b - radius * growth, c = ray.c - radius * radius;
    const double discriminant = b * b - a * c;
    if (discriminant < 0) continue;
    const double k = -(b + std::copysign(std::sqrt(discriminant), b));  // avoids cancellation
    for (const double root : {a != 0 ? k / a : -1, k != 0 ? c / k : -1})
      if (radius + growth * root >= 0) consider(root);  // otherwise on the other half of the cone, beyond its tip
  }
  if (!first) return std::nullopt;
  const ProfileSegment<double> s = segment(*this, first->segment);
  const revolution::Place<double> place = revolution::place(s, r.origin + first->t * r.direction);
  const Vec2d d = s.p1 - s.p0, off{place.r - s.p0.x, place.h - s.p0.y};
  const double w = std::clamp(dot2(off, d) / dot2(d, d), 0.0, 1.0);
  const Vec2d n = scaled(1 - w, s.n0) + scaled(w, s.n1);
  const Vec3d outwards = place.r > 0 ? n.x * place.u : Vec3d{};
  return ShapeHit{first->t, normalized(outwards + n.y * axis), static_cast<uint32_t>(first->segment), {w, 0}};
}

ShapePoint SurfaceOfRevolution::nearest(const Vec3d& p) const {
  const Vec3d from = p - origin;
  const double h = dot(from, axis);
  const Vec3d outwards = from - h * axis;
  const double r = length(outwards);
  const Vec3d out = r > 0 ? outwards / r : across(axis)[0];
  double best = 1e300, along = 0;
  Vec2d at{};
  size_t segment = 0;
  for (size_t i = 0; i + 1 < profile.size(); ++i) {
    const Vec2d &a = profile[i], &b = profile[i + 1];
    const double dx = b.x - a.x, dy = b.y - a.y, squared = dx * dx + dy * dy;
    const double w = squared > 0 ? std::clamp(((r - a.x) * dx + (h - a.y) * dy) / squared, 0.0, 1.0) : 0;
    const Vec2d q{a.x + w * dx, a.y + w * dy};
    const double distance = std::hypot(r - q.x, h - q.y);
    if (distance < best) best = distance, at = q, along = w, segment = i;
  }
  const Vec2d n0 = vertex_normal(segment), n1 = vertex_normal(segment + 1);
  const Vec2d normal{(1 - along) * n0.x + along * n1.x, (1 - along) * n0.y + along * n1.y};
  return {origin + at.y * axis + at.x * out, normalized(normal.x * out + normal.y * axis)};
}

// Ring radii are enlarged so that the chords between ring points are outside the surface.
TriMesh SurfaceOfRevolution::tessellated(double spacing) const {
  const auto [u, v] = across(axis);
  const auto around = static_cast<uint32_t>(std::clamp(std::ceil(2 * M_PI * largest_radius() / spacing), 12.0, 1e4));
  TriMesh out;
  for (const Vec2d& p : profile)
    for (uint32_t i = 0; i < around; ++i) {
      const double a = 2 * M_PI * i / around;
      out.positions.push_back(cast<float>(origin + p.y * axis + p.x * (std::cos(a) * u + std::sin(a) * v)));
    }
  for (uint32_t ring = 0; ring + 1 < profile.size(); ++ring)
    for (uint32_t i = 0; i < around; ++i) {
      const uint32_t next = (i + 1) % around, a = ring * around + i, b = ring * around + next, c = a + around, d = b + around;
      if (profile[ring].x > 0) out.faces.push_back({a, b, d});
      if (profile[ring + 1].x > 0) out.faces.push_back({a, d, c});
    }
  return out;
}

std::vector<Vec3d> SurfaceOfRevolution::outer_points() const {
  const auto [u, v] = across(axis);
  const double wider = 1 / std::cos(M_PI / kRingPoints);
  std::vector<Vec3d> out;
  for (const Vec2d& p : profile)
    for (int i = 0; i < kRingPoints; ++i) {
      const double a = 2 * M_PI * i / kRingPoints;
      out.push_back(origin + p.y * axis + wider * p.x * (std::cos(a) * u + std::sin(a) * v));
    }
  return out;
}

std::vector<ParameterGroup> SurfaceOfRevolution::parameters() const {
  return {{2, ParameterUnit::Length, 1}, {2, ParameterUnit::Angle, 1}, {profile.size(), ParameterUnit::Length, 1}};
}

Vec2d SurfaceOfRevolution::way(size_t i) const {
  if ((i == 0 || i + 1 == profile.size()) && profile[i].x <= 0) return {0, i == 0 ? -1. : 1.};
  const Vec2d n = vertex_normal(i);
  const double l = std::hypot(n.x, n.y);
  return l > 0 ? scaled(1 / l, n) : Vec2d{};
}

void SurfaceOfRevolution::hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const {
  const size_t i = hit.element, first = i > 0 ? i - 1 : 0, last = std::min(i + 2, profile.size() - 1);
  const ProfileSegment<double> back =
      revolution_point_vjp(segment(*this, i), ray.origin, ray.direction, hit.t, RevolutionPoint<double>{grad.t, grad.normal});
  const auto sides = across(axis);
  for (size_t c = 0; c < 2; ++c) out[c] += dot(back.origin, sides[c]), out[2 + c] += dot(back.axis, sides[c]);
  std::array<Vec2d, 4> g{};  // on the vertices from `first` on
  g[i - first] = back.p0, g[i + 1 - first] = back.p1;
  // A vertex normal is the sum over its segments.
  if (i > 0) segment_normal_vjp(*this, i - 1, back.n0, g, first);
  segment_normal_vjp(*this, i, back.n0 + back.n1, g, first);
  if (i + 2 < profile.size()) segment_normal_vjp(*this, i + 1, back.n1, g, first);
  for (size_t k = first; k <= last; ++k) out[4 + k] += dot2(g[k - first], way(k));
}

// place = o + h a + r u, (r, h) on the segment; tilting the axis rotates u: du = -(u.da) a.
void SurfaceOfRevolution::place_vjp(const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) const {
  const Vec3d q = place - origin;
  const double h = dot(q, axis);
  const Vec3d outwards = q - h * axis;
  const double r = length(outwards), w = hit.at.x;
  const Vec3d u = r > 0 ? outwards / r : Vec3d{};
  const Vec3d tilt = h * grad - (r * dot(grad, axis)) * u;
  const auto sides = across(axis);
  for (size_t c = 0; c < 2; ++c) out[c] += dot(grad, sides[c]), out[2 + c] += dot(tilt, sides[c]);
  const Vec2d g{dot(grad, u), dot(grad, axis)};
  out[4 + hit.element] += (1 - w) * dot2(g, way(hit.element));
  out[5 + hit.element] += w * dot2(g, way(hit.element + 1));
}

void SurfaceOfRevolution::smooth(std::span<double> grad) const {
  const std::span<double> slope = grad.subspan(4);
  const size_t n = slope.size();
  for (int pass = 0; pass < kProfileMixing; ++pass) {
    const std::vector<double> before(slope.begin(), slope.end());
    for (size_t i = 0; i < n; ++i) slope[i] = (before[i > 0 ? i - 1 : 0] + 2 * before[i] + before[i + 1 < n ? i + 1 : i]) / 4;
  }
}

SurfaceOfRevolution SurfaceOfRevolution::moved(std::span<const double> step) const {
  SurfaceOfRevolution out = *this;
  const auto sides = across(axis);
  for (size_t c = 0; c < 2; ++c) out.origin += step[c] * sides[c], out.axis += step[2 + c] * sides[c];
  out.axis = normalized(out.axis);
  for (size_t i = 0; i < profile.size(); ++i) {
    const Vec2d p = profile[i] + scaled(step[4 + i], way(i));
    out.profile[i] = {std::max(p.x, 0.0), p.y};
  }
  return out;
}

SurfaceOfRevolution with_equal_segments(const SurfaceOfRevolution& surface, size_t count) {
  const auto& p = surface.profile;
  std::vector<double> way(p.size(), 0.0);
  for (size_t i = 1; i < p.size(); ++i) way[i] = way[i - 1] + std::hypot(p[i].x - p[i - 1].x, p[i].y - p[i - 1].y);
  SurfaceOfRevolution out{surface.origin, surface.axis, {}};
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
