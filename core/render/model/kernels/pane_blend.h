// Reflections of the panes of a clear glass case in a pixel that looks into it (README 6; algorithms 5.8):
//   C_r' = M + m C_r                         near pane: M is its reflection of the scene, m the transmittance to the
//                                            reflection layer (beyond the scene: a sky that no photo shows)
//   C_t' = C_t + p (N + n C_r - C_t)         far pane, likewise; p = s F(f0, c'): s is the share of the pixel whose rays leave
//                                            through it, past everything in the case, c' the cosine there
// The panes are of the same glass: the far pane has the f0 of the near pane in the pixel. s, c' and the reflected pictures
// follow from geometry and have no gradient.
#pragma once

#include "core/render/model/kernels/fresnel.h"

namespace vitrine {

template <class T>
struct PaneView {
  Vec3<T> near_color{}, far_color{};  // M, N
  T near_open{1}, far_open{1};        // m, n
  T far_share{}, far_cosine{};        // s, c'
};

template <class T>
struct PaneRadiances {  // or their gradients
  Vec3<T> reflected{}, transmitted{};
};

// `c`: C_r, C_t; the result: C_r', C_t'.
template <class T>
PaneRadiances<T> behind_panes(const PaneView<T>& v, const Vec3<T>& f0, const PaneRadiances<T>& c) {
  PaneRadiances<T> out{v.near_color + v.near_open * c.reflected, c.transmitted};
  if (!(v.far_share > T(0))) return out;
  const Vec3<T> p = v.far_share * fresnel(f0, v.far_cosine, T(1)).value;
  out.transmitted += hadamard(p, v.far_color + v.far_open * c.reflected - c.transmitted);
  return out;
}

// Propagates the gradients of C_r', C_t' to C_r, C_t; adds to that of f0.
template <class T>
PaneRadiances<T> behind_panes_vjp(const PaneView<T>& v, const Vec3<T>& f0, const PaneRadiances<T>& c, const PaneRadiances<T>& g,
                                  Vec3<T>& grad_f0) {
  PaneRadiances<T> out{v.near_open * g.reflected, g.transmitted};
  if (!(v.far_share > T(0))) return out;
  const Fresnel<T> f = fresnel(f0, v.far_cosine, T(1));
  const Vec3<T> through = v.far_share * hadamard(f.value, g.transmitted);
  out.transmitted += T(-1) * through;
  out.reflected += v.far_open * through;
  T ignored(0);
  fresnel_vjp(f0, f, v.far_share * hadamard(g.transmitted, v.far_color + v.far_open * c.reflected - c.transmitted), grad_f0,
              ignored, ignored);
  return out;
}

}  // namespace vitrine
