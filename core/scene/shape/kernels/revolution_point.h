// Ray hit on one profile segment of a surface of revolution with its smooth normal, and the backward pass to the axis, the
// segment and the normals at its ends.
//   q = eye + t ray - o   h = q.a   r = |q - h a|   u = (q - h a)/r      [the point (r, h) of the half plane]
// s.((r, h) - p0) = 0 defines t, s = normal of the segment   w: position along the segment, p0 -> 0, p1 -> 1
//   m = (1-w) n0 + w n1   n = |m.x u + m.y a|^-1 (m.x u + m.y a)          (algorithms 9.4)
#pragma once

#include <cmath>

#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
struct ProfileSegment {  // or its gradient
  Vec3<T> origin{}, axis{};
  Vec2<T> p0{}, p1{}, n0{}, n1{};  // ends (radius, height); normals at the ends, of any length
};

template <class T>
struct RevolutionPoint {  // or its gradient
  T t{};
  Vec3<T> normal{};
};

namespace revolution {

template <class T>
T dot2(const Vec2<T>& a, const Vec2<T>& b) {
  return a.x * b.x + a.y * b.y;
}

template <class T>
struct Place {
  Vec3<T> q, u;
  T h, r;
};
template <class T>
Place<T> place(const ProfileSegment<T>& s, const Vec3<T>& point) {
  Place<T> p;
  p.q = point - s.origin;
  p.h = dot(p.q, s.axis);
  const Vec3<T> across = p.q - p.h * s.axis;
  p.r = length(across);
  p.u = (T(1) / p.r) * across;
  return p;
}

}  // namespace revolution

// `near`: approximate t of the intersection; refined by one Newton step.
template <class T>
RevolutionPoint<T> revolution_point(const ProfileSegment<T>& s, const Vec3<T>& eye, const Vec3<T>& ray, const T& near) {
  using revolution::dot2;
  const Vec2<T> d{s.p1.x - s.p0.x, s.p1.y - s.p0.y}, normal{d.y, -d.x};
  const revolution::Place<T> start = revolution::place(s, eye + near * ray);
  const T off = normal.x * (start.r - s.p0.x) + normal.y * (start.h - s.p0.y);
  const T slope = normal.x * dot(start.u, ray) + normal.y * dot(s.axis, ray);
  RevolutionPoint<T> out;
  out.t = near - off / slope;
  const revolution::Place<T> p = revolution::place(s, eye + out.t * ray);
  const T w = ((p.r - s.p0.x) * d.x + (p.h - s.p0.y) * d.y) / dot2(d, d);
  const Vec2<T> m{(T(1) - w) * s.n0.x + w * s.n1.x, (T(1) - w) * s.n0.y + w * s.n1.y};
  out.normal = normalized(m.x * p.u + m.y * s.axis);
  return out;
}

// `t`: of the hit point. The gradient on the axis direction includes its length: the caller projects it.
template <class T>
ProfileSegment<T> revolution_point_vjp(const ProfileSegment<T>& s, const Vec3<T>& eye, const Vec3<T>& ray, const T& t,
                                       const RevolutionPoint<T>& g) {
  using revolution::dot2;
  const Vec2<T> d{s.p1.x - s.p0.x, s.p1.y - s.p0.y};
  const T squared = dot2(d, d);
  const revolution::Place<T> p = revolution::place(s, eye + t * ray);
  const T w = ((p.r - s.p0.x) * d.x + (p.h - s.p0.y) * d.y) / squared;
  const Vec2<T> m{(T(1) - w) * s.n0.x + w * s.n1.x, (T(1) - w) * s.n0.y + w * s.n1.y};
  const Vec3<T> gm = normalized_vjp(m.x * p.u + m.y * s.axis, g.normal);

  ProfileSegment<T> out;
  const Vec2<T> g2{dot(gm, p.u), dot(gm, s.axis)};
  const Vec3<T> gu = m.x * gm;
  out.axis = m.y * gm;
  out.n0 = {(T(1) - w) * g2.x, (T(1) - w) * g2.y};
  out.n1 = {w * g2.x, w * g2.y};
  const T gw = g2.x * (s.n1.x - s.n0.x) + g2.y * (s.n1.y - s.n0.y);
  const Vec2<T> g_along{gw / squared * d.x, gw / squared * d.y};  // with respect to (r, h); the ends receive (1-w) and w of it
  // From (r, h) to the point and the axis.
  const Vec3<T> across = g_along.x * p.u + (T(1) / p.r) * (gu - dot(gu, p.u) * p.u);
  const T gh = g_along.y - dot(across, s.axis);
  const Vec3<T> gq = across + gh * s.axis;
  out.axis += gh * p.q - p.h * across;
  out.origin = -gq;
  // The hit point moves along the ray as the surface moves.
  const T gt = g.t + dot(gq, ray);
  const Vec2<T> normal{d.y, -d.x};
  const T step = -gt / (normal.x * dot(p.u, ray) + normal.y * dot(s.axis, ray));
  out.origin += step * (-(normal.x * p.u + normal.y * s.axis));
  out.axis += step * (normal.y * p.q - (normal.x * p.h) * p.u);
  const T g0 = T(1) - w;
  out.p0 = {-g0 * (g_along.x + step * normal.x), -g0 * (g_along.y + step * normal.y)};
  out.p1 = {-w * (g_along.x + step * normal.x), -w * (g_along.y + step * normal.y)};
  return out;
}

}  // namespace vitrine
