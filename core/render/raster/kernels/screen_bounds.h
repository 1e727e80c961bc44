// Screen bounds of a surfel: an ellipse and a box of pixels around it, and the test against rectangles of pixels with a lower
// bound of its depth there (README 6). Lists of tiles and blocks are made by it. T is the scalar or the SIMD type; it brings min,
// max, clamp, absolute, sqrt and log_of (natural logarithm, absolute error below 2e-5).
#pragma once

#include <cmath>
#include <cstdint>

#include "core/render/raster/kernels/project.h"
#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine {

// Screen bounds of a surfel: the ellipse rho3d <= cut as y^2 inv_yy + (x - shear_xy y)^2 inv_xx <= 1 around (ex, ey), and the
// disc of the low-pass around the projected mean. Boxes are pixels, inclusive.
struct alignas(64) SplatBounds {
  float ex, ey, inv_yy, inv_xx, shear_xy, shear_yx;
  float disc_r2;        // negative: no low-pass
  float z_low, z_high;  // of the part of the disc u^2 + v^2 <= cut in front of the eye
  float cx, cy, z0, h0, h1;
  int16_t x_first, x_last, y_first, y_last;
};
static_assert(sizeof(SplatBounds) == 64);

// Sigma of the ellipse rho3d <= cut: (cut/k) (P + (cut/k) (P h)(P h)^T), P = (M^T M)^-1, k = 1 - cut |W|^2 / z0^2, with P and P
// h written in terms of the columns A, B and W = (a_u.z, a_v.z), which avoids cancellation. k > 0: all of it is in front of the
// eye.
template <class T, class Mask = decltype(T() < T())>
struct EllipseBounds {
  T ex, ey, inv_yy, inv_xx, shear_xy, shear_yx, disc_r2, z_low, z_high, half_x, half_y, cut;
  Mask is_ellipse;
};

inline constexpr float kCutSlack = 1.0005f;  // the cut is compared with rounded values
inline constexpr float kThinnest = 1e-4f;    // px^2 added to Sigma: keeps the test of needle-thin ellipses safe

template <class T>
VITRINE_INLINE EllipseBounds<T> ellipse_bounds(const Projection<T>& p, T opacity, T near_z, bool low_pass) {
  EllipseBounds<T> b;
  const T one(1.f), z0 = p.map.z0, wu = p.a_u.z, wv = p.a_v.z, inv_z2 = one / (z0 * z0);
  b.cut = max(T(2.f) * log_of(max(opacity, T(1e-30f)) * T(255.f)), T(0.f)) * T(kCutSlack) + T(1e-3f);
  const T w2 = wu * wu + wv * wv, k = one - b.cut * w2 * inv_z2;
  const T depth_reach = sqrt(b.cut * w2);
  b.z_low = max(z0 - depth_reach, near_z);
  b.z_high = z0 + depth_reach;
  b.is_ellipse = (k > T(1e-3f)) & (z0 - depth_reach > near_z);
  const T beta = b.cut / k;
  const T pxx = (p.Au * p.Au + p.Av * p.Av) * inv_z2, pxy = (p.Au * p.Bu + p.Av * p.Bv) * inv_z2,
          pyy = (p.Bu * p.Bu + p.Bv * p.Bv) * inv_z2;
  const T hx = -(p.Au * wu + p.Av * wv) * inv_z2, hy = -(p.Bu * wu + p.Bv * wv) * inv_z2;
  b.ex = p.map.cx + beta * hx;
  b.ey = p.map.cy + beta * hy;
  const T thin(kThinnest);
  const T sxx = beta * (pxx + beta * hx * hx), sxy = beta * (pxy + beta * hx * hy), syy = beta * (pyy + beta * hy * hy);
  const T root = p.det * inv_z2;
  const T det = beta * beta * root * root / k + thin * (sxx + syy) + thin * thin;
  const T txx = sxx + thin, tyy = syy + thin;
  b.inv_yy = one / tyy;
  b.inv_xx = tyy / det;
  b.shear_xy = sxy / tyy;
  b.shear_yx = sxy / txx;
  b.half_x = sqrt(txx);
  b.half_y = sqrt(tyy);
  b.disc_r2 = low_pass ? b.cut * T(0.5f) : T(-1.f);
  return b;
}

template <class T>
struct ScreenBox {
  T x_lo, x_hi, y_lo, y_hi;
  VITRINE_HD void add(T x, T y) {
    x_lo = x < x_lo ? x : x_lo;
    x_hi = x > x_hi ? x : x_hi;
    y_lo = y < y_lo ? y : y_lo;
    y_hi = y > y_hi ? y : y_hi;
  }
};

template <class T>
struct ScreenColumns {
  T Au, Av, Bu, Bv, wu, wv, cx, cy, z0;
};

// Box of a surfel that crosses the near plane: projection of an octagon around its disc, clipped at the plane.
template <class T>
VITRINE_INLINE ScreenBox<T> clipped_box(const ScreenColumns<T>& s, T radius, T near_z) {
  constexpr int kCorners = 8;
  constexpr float kOctagon = 1.0823922f;  // circumscribed: 1 / cos(pi/8)
  constexpr float kCos[kCorners] = {1.f, 0.70710678f, 0.f, -0.70710678f, -1.f, -0.70710678f, 0.f, 0.70710678f};
  ScreenBox<T> box{T(1e30f), T(-1e30f), T(1e30f), T(-1e30f)};
  T u[kCorners], v[kCorners], z[kCorners];
  for (int i = 0; i < kCorners; ++i) {
    u[i] = radius * T(kOctagon) * T(kCos[i]);
    v[i] = radius * T(kOctagon) * T(kCos[(i + 6) % kCorners]);
    z[i] = s.z0 + s.wu * u[i] + s.wv * v[i];
  }
  const auto add = [&](T pu, T pv, T pz) { box.add(s.cx + (s.Au * pu + s.Av * pv) / pz, s.cy + (s.Bu * pu + s.Bv * pv) / pz); };
  for (int i = 0; i < kCorners; ++i) {
    const int j = (i + 1) % kCorners;
    if (z[i] >= near_z) add(u[i], v[i], z[i]);
    if ((z[i] >= near_z) != (z[j] >= near_z)) {
      const T t = (near_z - z[i]) / (z[j] - z[i]);
      add(u[i] + t * (u[j] - u[i]), v[i] + t * (v[j] - v[i]), near_z);
    }
  }
  return box;
}

// First and last pixel whose centre lies in [lo, hi]; empty (first > last) outside the image.
VITRINE_INLINE void pixel_range(float lo, float hi, int size, int16_t& first, int16_t& last) {
  using std::ceil, std::floor;
  const float a = lo - 0.5f, b = hi - 0.5f;
  first = static_cast<int16_t>(a <= 0.f ? 0.f : a >= float(size) ? float(size) : ceil(a));
  last = static_cast<int16_t>(b < 0.f ? -1.f : b >= float(size - 1) ? float(size - 1) : floor(b));
}

// Whether a surfel touches a rectangle of pixel centres, and a lower bound of its depth there.
template <class T, class Mask = decltype(T() < T())>
struct RectangleTest {
  Mask hit;
  T z_min;
};

// Pixel centres [left, left + side] x [top, top + side].
template <class T>
VITRINE_INLINE RectangleTest<T> test_rectangle(const SplatBounds& b, const T& left, const T& top, float side_px) {
  constexpr float kDepthSlack = 1e-5f;  // rounding error of z over the rectangle
  const T zero(0.f), side(side_px);
  // The minimum of a convex quadratic over a rectangle lies on the two edges that face its centre (or at the centre).
  const T x_lo = left - T(b.ex), x_hi = x_lo + side, y_lo = top - T(b.ey), y_hi = y_lo + side;
  const T x_near = clamp(zero, x_lo, x_hi), y_near = clamp(zero, y_lo, y_hi);
  const T y_at = clamp(x_near * T(b.shear_yx), y_lo, y_hi), x_at = clamp(y_near * T(b.shear_xy), x_lo, x_hi);
  const T across_1 = x_near - T(b.shear_xy) * y_at, across_2 = x_at - T(b.shear_xy) * y_near;
  const T q1 = across_1 * across_1 * T(b.inv_xx) + y_at * y_at * T(b.inv_yy);
  const T q2 = across_2 * across_2 * T(b.inv_xx) + y_near * y_near * T(b.inv_yy);
  const auto ellipse = min(q1, q2) <= T(1.f);

  const T dx_lo = left - T(b.cx), dy_lo = top - T(b.cy);
  const T dx = clamp(zero, dx_lo, dx_lo + side), dy = clamp(zero, dy_lo, dy_lo + side);
  const auto disc = dx * dx + dy * dy <= T(b.disc_r2);

  // 1/z is affine on the screen: its extremes over a block are at corners.
  const T half(0.5f * side_px);
  const T den = T(1.f) + T(b.h0) * (dx_lo + half) + T(b.h1) * (dy_lo + half);
  const T reach = half * (absolute(T(b.h0)) + absolute(T(b.h1)));
  const T z0(b.z0), z_low(b.z_low), z_high(b.z_high), den_far = den + reach;
  RectangleTest<T> t;
  t.hit = ellipse | disc;
  t.z_min = select(den_far > zero, max(z0 / den_far, z_low), z_high);
  t.z_min = select(disc, min(t.z_min, z0), t.z_min) * T(1.f - kDepthSlack);
  return t;
}

}  // namespace vitrine
