// Projection of a surfel to the screen, and its reverse (README 1-2).
//
// A surfel point is X(u,v) = mean + s_u u r0 + s_v v r1. In the camera frame the columns are a_u, a_v, a_0; the homogeneous
// screen point is (Tu, Tv, Tw).(u,v,1). A pixel at offset d = (px,py) - c from the projected mean c intersects the plane at
//     u = (m00 dx + m01 dy) / den,  v = (m10 dx + m11 dy) / den,  z = z0 / den,  den = 1 + h0 dx + h1 dy
// This is the inverse of that 3x3 map written around c: the cross product k x l of Huang et al. 2024 ("2D Gaussian Splatting",
// eq. 8 to 10; algorithms 1.2, 1.3) multiplied out. Offsets are small numbers, so float keeps its precision, and a fragment
// costs three multiply-adds and one reciprocal.
#pragma once

#include "core/foundation/math/rigid.h"
#include "core/foundation/math/vec.h"
#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine {

template <class T>
struct Camera {
  T fx, fy, cx, cy;
  Mat3<T> rotation;  // cam_from_world
  Vec3<T> translation;
  Vec3<T> eye;  // in world
};

template <class T>
struct SurfelGeometry {  // raw values, or their gradients
  Vec3<T> mean{};
  Quat<T> rotation{T(0), T(0), T(0), T(0)};
  T log_su{}, log_sv{};
};

template <class T>
struct ScreenMap {  // the nine numbers of a surfel in a view, or their gradients
  T cx{}, cy{}, z0{};
  T m00{}, m01{}, m10{}, m11{};
  T h0{}, h1{};
};

template <class T>
struct Projection {
  ScreenMap<T> map;
  Vec3<T> normal;  // world, faces the camera
  T facing;        // +1 or -1: normal = facing * r2
  // Shared with the reverse.
  Mat3<T> frame;  // [r0 r1 r2]
  T su, sv;
  Vec3<T> a_u, a_v;  // camera frame, scaled
  T xn, yn;          // a_0 / z0
  T Au, Av, Bu, Bv;  // columns of z0 * d(screen)/d(u,v) at the mean
  T det, scale;      // Au Bv - Av Bu = scale * normal.(xn, yn, 1)
};

template <class T>
VITRINE_HD Projection<T> project(const SurfelGeometry<T>& s, const Camera<T>& camera) {
  using std::exp;
  Projection<T> p;
  p.frame = rotation_matrix(normalized(s.rotation));
  p.su = exp(s.log_su);
  p.sv = exp(s.log_sv);
  const Vec3<T> a_0 = camera.rotation * s.mean + camera.translation;
  p.a_u = p.su * (camera.rotation * p.frame.c0);
  p.a_v = p.sv * (camera.rotation * p.frame.c1);
  const T z0 = a_0.z, inv_z = T(1) / z0;
  p.xn = a_0.x * inv_z;
  p.yn = a_0.y * inv_z;
  p.Au = camera.fx * (p.a_u.x - p.xn * p.a_u.z);
  p.Av = camera.fx * (p.a_v.x - p.xn * p.a_v.z);
  p.Bu = camera.fy * (p.a_u.y - p.yn * p.a_u.z);
  p.Bv = camera.fy * (p.a_v.y - p.yn * p.a_v.z);
  p.det = p.Au * p.Bv - p.Av * p.Bu;
  p.scale = camera.fx * camera.fy * p.su * p.sv;
  const T inv = T(1) / p.det, wu = p.a_u.z, wv = p.a_v.z;
  p.map = {camera.fx * p.xn + camera.cx,
           camera.fy * p.yn + camera.cy,
           z0,
           z0 * p.Bv * inv,
           -z0 * p.Av * inv,
           -z0 * p.Bu * inv,
           z0 * p.Au * inv,
           (wv * p.Bu - wu * p.Bv) * inv,
           (wu * p.Av - wv * p.Au) * inv};
  p.facing = select(dot(p.frame.c2, s.mean - camera.eye) > T(0), T(-1), T(1));
  p.normal = p.facing * p.frame.c2;
  return p;
}

// False for NaN, behind or at the near plane, exactly edge-on, or too transparent.
template <class T>
VITRINE_HD auto is_visible(const Projection<T>& p, const T& opacity, const T& near_z) {
  const T size = select(p.det < T(0), -p.det, p.det);
  return (p.map.z0 > near_z) & (size > T(kEdgeOn) * p.scale) & (opacity > T(kMinAlpha));
}

template <class T>
struct ProjectionGrad {
  SurfelGeometry<T> surfel;
  T screen_x, screen_y;  // dL/d(projected centre), the ellipse moving rigidly (Huang et al. 2024, densification)
};

// Reverse of project: from gradients of the map's nine numbers and of the facing normal to gradients of the raw geometry.
template <class T>
VITRINE_HD ProjectionGrad<T> project_vjp(const SurfelGeometry<T>& s, const Camera<T>& camera, const Projection<T>& p,
                                         const ScreenMap<T>& g, const Vec3<T>& grad_normal) {
  const T inv = T(1) / p.det, z0 = p.map.z0, inv_z = T(1) / z0, wu = p.a_u.z, wv = p.a_v.z;
  const T g_det =
      -inv * (g.m00 * p.map.m00 + g.m01 * p.map.m01 + g.m10 * p.map.m10 + g.m11 * p.map.m11 + g.h0 * p.map.h0 + g.h1 * p.map.h1);
  const T g_Au = inv * (z0 * g.m11 - wv * g.h1) + g_det * p.Bv;
  const T g_Av = inv * (wu * g.h1 - z0 * g.m01) - g_det * p.Bu;
  const T g_Bu = inv * (wv * g.h0 - z0 * g.m10) - g_det * p.Av;
  const T g_Bv = inv * (z0 * g.m00 - wu * g.h0) + g_det * p.Au;
  const T g_xn = camera.fx * (g.cx - wu * g_Au - wv * g_Av);
  const T g_yn = camera.fy * (g.cy - wu * g_Bu - wv * g_Bv);
  const Vec3<T> g_au{camera.fx * g_Au, camera.fy * g_Bu,
                     inv * (p.Av * g.h1 - p.Bv * g.h0) - camera.fx * p.xn * g_Au - camera.fy * p.yn * g_Bu};
  const Vec3<T> g_av{camera.fx * g_Av, camera.fy * g_Bv,
                     inv * (p.Bu * g.h0 - p.Au * g.h1) - camera.fx * p.xn * g_Av - camera.fy * p.yn * g_Bv};
  const T g_z0 = g.z0 + inv * (p.Bv * g.m00 - p.Av * g.m01 - p.Bu * g.m10 + p.Au * g.m11);
  const Vec3<T> g_a0{g_xn * inv_z, g_yn * inv_z, g_z0 - (g_xn * p.xn + g_yn * p.yn) * inv_z};

  ProjectionGrad<T> out;
  out.surfel.mean = transposed_times(camera.rotation, g_a0);
  const Vec3<T> b_u = transposed_times(camera.rotation, g_au), b_v = transposed_times(camera.rotation, g_av);
  out.surfel.log_su = dot(g_au, p.a_u);
  out.surfel.log_sv = dot(g_av, p.a_v);
  out.surfel.rotation = rotation_matrix_vjp(s.rotation, Mat3<T>{p.su * b_u, p.sv * b_v, p.facing * grad_normal});
  out.screen_x = g.cx - wu * g_Au - wv * g_Av;
  out.screen_y = g.cy - wu * g_Bu - wv * g_Bv;
  return out;
}

}  // namespace vitrine
