// Weight and depth of one surfel at one pixel, and the reverse (README 2-3). T is the pixel's scalar or SIMD vector, P the
// scalar type of the surfel's constants, which are broadcast.
//
//   rho3d = u^2 + v^2 on the surfel's plane; rho2d = 2 |d|^2, the screen low-pass (Botsch et al. 2005; Huang et al. 2024, eq. 11)
//   G     = exp(-min(rho3d, rho2d)/2)
//   alpha = min(0.99, opacity G), 0 when below 1/255
//   z     = plane depth where rho3d is smaller, depth of the centre where the low-pass is: there the surfel acts as a dot
//           facing the camera, and the plane of an edge-on surfel would give an arbitrary depth.
// Where the plane is closer than near_z or behind the eye, rho3d counts as infinite.
#pragma once

#include "core/render/raster/kernels/project.h"
#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine {

template <class T, class Mask = decltype(T() < T())>
struct SplatSample {
  T dx, dy;
  T u, v, inv_den;  // of the plane
  T rho3d;
  T alpha;  // 0 if not counted
  T z;
  Mask on_plane;  // rho3d is the minimum
  Mask counts;    // alpha >= 1/255
  Mask free;      // below the clamp: gradients flow
};

template <class P>
struct SplatConstants {
  ScreenMap<P> map;
  P opacity;
  P min_inv_den;  // near_z / z0
  P low_pass;     // kLowPassInvVariance or kNoLowPass
};

template <class T, class P>
VITRINE_INLINE SplatSample<T> splat_sample(const SplatConstants<P>& s, const T& px, const T& py) {
  SplatSample<T> f;
  f.dx = px - T(s.map.cx);
  f.dy = py - T(s.map.cy);
  const T den = T(1) + (T(s.map.h1) * f.dy + T(s.map.h0) * f.dx);
  f.inv_den = reciprocal(den);
  f.u = (T(s.map.m01) * f.dy + T(s.map.m00) * f.dx) * f.inv_den;
  f.v = (T(s.map.m11) * f.dy + T(s.map.m10) * f.dx) * f.inv_den;
  f.rho3d = f.u * f.u + f.v * f.v;
  const T rho2d = T(s.low_pass) * (f.dy * f.dy + f.dx * f.dx);
  f.on_plane = (f.rho3d <= rho2d) & (f.inv_den >= T(s.min_inv_den));
  const T peak = T(s.opacity) * gaussian(select(f.on_plane, f.rho3d, rho2d));
  f.free = peak < T(kMaxAlpha);
  f.counts = peak >= T(kMinAlpha);
  f.alpha = select(f.counts, select(f.free, peak, T(kMaxAlpha)), T(0));
  f.z = T(s.map.z0) * select(f.on_plane, f.inv_den, T(1));
  return f;
}

// Contribution of a fragment to the gradients of its surfel, before the sums over pixels. With d = (dx, dy):
//   grad m0j = sum num_u d_j     grad m1j = sum num_v d_j     grad hj = sum den d_j
//   grad c   = 2 sum disc d - M^T sum (num_u, num_v) - h sum den
//   grad z0  = sum z0            grad (raw opacity) = (1 - opacity) sum weight
template <class T>
struct SampleGrad {
  T num_u, num_v, den, disc, weight, z0;
};

template <class T>
VITRINE_INLINE SampleGrad<T> splat_sample_vjp(const SplatSample<T>& f, const T& grad_alpha, const T& grad_z) {
  SampleGrad<T> g;
  const T zero(0);
  g.weight = select(f.free & f.counts, f.alpha * grad_alpha, zero);
  g.disc = select(f.on_plane, zero, g.weight);
  // select instead of multiply by zero: u and 1/den may be infinite where the plane is not used.
  const T slope = g.weight * f.inv_den;
  g.num_u = select(f.on_plane, zero - slope * f.u, zero);
  g.num_v = select(f.on_plane, zero - slope * f.v, zero);
  g.den = select(f.on_plane, f.inv_den * (g.weight * f.rho3d - grad_z * f.z), zero);
  g.z0 = grad_z * select(f.on_plane, f.inv_den, T(1));
  return g;
}

// Sums over pixels: s = sum x, sx = sum x dx, sy = sum x dy for each of the moments above.
template <class T>
struct SplatMoments {
  T num_u{}, num_u_x{}, num_u_y{}, num_v{}, num_v_x{}, num_v_y{}, den{}, den_x{}, den_y{}, disc_x{}, disc_y{}, weight{}, z0{};

  VITRINE_HD void add(const SampleGrad<T>& g, const T& dx, const T& dy) {
    num_u += g.num_u;
    num_u_x += g.num_u * dx;
    num_u_y += g.num_u * dy;
    num_v += g.num_v;
    num_v_x += g.num_v * dx;
    num_v_y += g.num_v * dy;
    den += g.den;
    den_x += g.den * dx;
    den_y += g.den * dy;
    disc_x += g.disc * dx;
    disc_y += g.disc * dy;
    weight += g.weight;
    z0 += g.z0;
  }
};

template <class T>
struct SplatGrad {
  ScreenMap<T> map;
  T raw_opacity;
};

// Without low-pass no fragment is a disc, so its slope applies to both cases.
template <class T>
VITRINE_HD SplatGrad<T> splat_grad(const SplatMoments<T>& m, const ScreenMap<T>& map, const T& opacity) {
  const T slope(kLowPassInvVariance);
  SplatGrad<T> g;
  g.map.m00 = m.num_u_x;
  g.map.m01 = m.num_u_y;
  g.map.m10 = m.num_v_x;
  g.map.m11 = m.num_v_y;
  g.map.h0 = m.den_x;
  g.map.h1 = m.den_y;
  g.map.cx = slope * m.disc_x - (map.m00 * m.num_u + map.m10 * m.num_v + map.h0 * m.den);
  g.map.cy = slope * m.disc_y - (map.m01 * m.num_u + map.m11 * m.num_v + map.h1 * m.den);
  g.map.z0 = m.z0;
  g.raw_opacity = (T(1) - opacity) * m.weight;
  return g;
}

}  // namespace vitrine
