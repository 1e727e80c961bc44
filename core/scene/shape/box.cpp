#include "core/scene/shape/box.h"

#include "core/scene/shape/hit.h"

namespace vitrine {

double Box::distance(const Vec3d& p) const {
  const Vec3d q = transposed_times(axes, p);
  Vec3d outside{};
  double inside = -1e300;
  for (size_t i = 0; i < 3; ++i) {
    const double d = std::max(low[i] - q[i], q[i] - high[i]);
    outside[i] = std::max(d, 0.0);
    inside = std::max(inside, d);
  }
  return inside < 0 ? inside : length(outside);
}

std::optional<Box::Crossing> Box::crossing(const Vec3d& origin, const Vec3d& direction) const {
  const Vec3d o = transposed_times(axes, origin), d = transposed_times(axes, direction);
  Crossing c{0, 1e300, {}, {}};
  for (size_t i = 0; i < 3; ++i) {
    const double a = (low[i] - o[i]) / d[i], b = (high[i] - o[i]) / d[i];
    if (std::min(a, b) > c.in) c.in = std::min(a, b), c.entered = {i, d[i] < 0};
    if (std::max(a, b) < c.out) c.out = std::max(a, b), c.left = {i, d[i] > 0};
  }
  if (!(c.in > 0) || !(c.in < c.out)) return std::nullopt;
  return c;
}

std::optional<ShapeHit> Box::intersect(const Ray& ray) const {
  const auto c = crossing(ray.origin, ray.direction);
  if (!c) return std::nullopt;
  return ShapeHit{c->in, normal(c->entered), static_cast<uint32_t>(c->entered.index()), {}};
}

// Outside: clamped to the box. Inside: projected to the nearest face.
ShapePoint Box::nearest(const Vec3d& p) const {
  const Vec3d q = transposed_times(axes, p);
  Vec3d on = q;
  Face best{};
  double least = -1e300;  // signed distance beyond that face
  for (size_t i = 0; i < 3; ++i) {
    on[i] = std::clamp(q[i], low[i], high[i]);
    for (const bool upper : {false, true})
      if (const double beyond = upper ? q[i] - high[i] : low[i] - q[i]; beyond > least) least = beyond, best = {i, upper};
  }
  if (least < 0) on[best.axis] = best.upper ? high[best.axis] : low[best.axis];
  return {axes * on, normal(best)};
}

std::vector<Vec3d> Box::outer_points() const {
  std::vector<Vec3d> out;
  for (size_t i = 0; i < 8; ++i) out.push_back(corner(i));
  return out;
}

TriMesh Box::tessellated(double) const {
  TriMesh out;
  for (size_t i = 0; i < 8; ++i) out.positions.push_back(cast<float>(corner(i)));
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const uint32_t u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3, w = 1u << axis;  // right-handed
    out.faces.insert(out.faces.end(), {{0, v, u}, {u, v, u | v}, {w, w | u, w | v}, {w | u, w | u | v, w | v}});
  }
  return out;
}

std::vector<Facet> Box::facets() const {
  std::vector<Facet> out;
  for (size_t f = 0; f < kFaces; ++f) out.push_back({normal(face(f)), offset(face(f))});
  return out;
}

std::vector<ParameterGroup> Box::parameters() const { return {{3, ParameterUnit::Angle, 1}, {6, ParameterUnit::Length, 1}}; }

// n.(o + t d - c) = h: dt = (dh - dn.(p - c)) / n.d, dn = w x n.
void Box::hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const {
  const Face f = face(hit.element);
  const Vec3d& n = hit.normal;
  const double by = grad.t / dot(n, ray.direction);
  const Vec3d turn = cross(n, grad.normal) + cross(ray.origin + hit.t * ray.direction - centre(), by * n);
  for (size_t c = 0; c < 3; ++c) out[c] += turn[c];
  out[(f.upper ? 6 : 3) + f.axis] += f.upper ? by : -by;
}

void Box::place_vjp(const ShapeHit&, const Vec3d& place, const Vec3d& grad, std::span<double> out) const {
  const Vec3d turn = cross(place - centre(), grad), q = transposed_times(axes, place), g = transposed_times(axes, grad);
  for (size_t c = 0; c < 3; ++c) {
    const double along = (q[c] - low[c]) / (high[c] - low[c]);
    out[c] += turn[c], out[3 + c] += (1 - along) * g[c], out[6 + c] += along * g[c];
  }
}

Box Box::moved(std::span<const double> step) const {
  Box out{turned_by({step[0], step[1], step[2]}, axes), {}, {}};
  const Vec3d middle = transposed_times(out.axes, centre());
  for (size_t c = 0; c < 3; ++c) {
    const double half = 0.5 * (high[c] - low[c]), least = kLeastExtent_rel * half;
    out.low[c] = middle[c] + std::min(-half + step[3 + c], -least);
    out.high[c] = middle[c] + std::max(half + step[6 + c], least);
  }
  return out;
}

}  // namespace vitrine
