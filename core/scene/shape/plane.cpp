#include "core/scene/shape/plane.h"

#include <cmath>

#include "core/scene/shape/hit.h"

namespace vitrine {

std::optional<ShapeHit> Plane::intersect(const Ray& ray) const {
  const Vec3d o = transposed_times(axes, ray.origin - centre), d = transposed_times(axes, ray.direction);
  const double t = -o.z / d.z;
  if (!(t > 0) || !std::isfinite(t)) return std::nullopt;
  const Vec2d at{o.x + t * d.x, o.y + t * d.y};
  if (std::abs(at.x) > half.x || std::abs(at.y) > half.y) return std::nullopt;
  return ShapeHit{t, d.z < 0 ? axes.c2 : -axes.c2, d.z < 0 ? 0u : 1u, at};
}

ShapePoint Plane::nearest(const Vec3d& p) const {
  const Vec3d q = transposed_times(axes, p - centre);
  return {centre + std::clamp(q.x, -half.x, half.x) * axes.c0 + std::clamp(q.y, -half.y, half.y) * axes.c1,
          q.z < 0 ? -axes.c2 : axes.c2};
}

TriMesh Plane::tessellated(double) const {
  TriMesh out;
  for (const Vec3d& p : outer_points()) out.positions.push_back(cast<float>(p));
  out.faces = {{0, 2, 1}, {1, 2, 3}};
  return out;
}

std::vector<Vec3d> Plane::outer_points() const {
  std::vector<Vec3d> out;
  for (const double x : {-half.x, half.x})
    for (const double y : {-half.y, half.y}) out.push_back(centre + x * axes.c0 + y * axes.c1);
  return out;
}

std::vector<ParameterGroup> Plane::parameters() const {
  return {{3, ParameterUnit::Angle, 1}, {3, ParameterUnit::Length, 1}, {2, ParameterUnit::Length, 1}};
}

// n.(o + t d - c) = 0: dt = (n.dc - dn.(p - c)) / n.d, dn = w x n.
void Plane::hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const {
  const Vec3d& n = hit.normal;
  const Vec3d arm = ray.origin + hit.t * ray.direction - centre, by = grad.t / dot(n, ray.direction) * n;
  const Vec3d turn = cross(n, grad.normal) + cross(arm, by);
  for (size_t c = 0; c < 3; ++c) out[c] += turn[c], out[3 + c] += by[c];
}

void Plane::place_vjp(const ShapeHit&, const Vec3d& place, const Vec3d& grad, std::span<double> out) const {
  const Vec3d arm = place - centre, turn = cross(arm, grad);
  for (size_t c = 0; c < 3; ++c) out[c] += turn[c], out[3 + c] += grad[c];
  for (size_t c = 0; c < 2; ++c) out[6 + c] += dot(arm, axes.column(c)) / half[c] * dot(axes.column(c), grad);
}

Plane Plane::moved(std::span<const double> step) const {
  Plane out = *this;
  out.axes = turned_by({step[0], step[1], step[2]}, axes);
  out.centre += Vec3d{step[3], step[4], step[5]};
  for (size_t c = 0; c < 2; ++c) out.half[c] = std::max(half[c] + step[6 + c], kLeastExtent_rel * half[c]);
  return out;
}

}  // namespace vitrine
