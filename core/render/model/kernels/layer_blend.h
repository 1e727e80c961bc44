// Blend of the radiance of the three layers into a pixel (README 4):  C = w_d C_d + w_r C_r + w_t C_t,  per channel, with
//   rtrgs    w_d = 1 - k_s          w_r = k_s F    w_t = k_s tau (1 - F)
//   layered  w_d = (1-k)(1-tau)     w_r = k        w_t = (1-k) tau       k = k_s + (1 - k_s) G F
// `layered` has the form of Na et al. 2026 ("GLINT"), without G; separate surfel sets for reflection and transmission follow
// Zeng et al. 2026 ("RT-GS"); algorithms 3.3. F is the Fresnel term at the view angle; tau is the degree to which the surface
// is thin glass (fresnel.h).
//   G = g + (1 - g) tau h    g = 1 - (1 - x)^2, h = smoothstep(0, 0.001, k_s)    g = 1 on a coat (ShapeRole::Coat)
// g fades Fresnel out on surfaces without specular weight, so that an opaque pixel keeps exactly its diffuse colour: x =
// clamp((k_s - t)/(s - t), 0, 1), zero at the threshold t below which a pixel sends no rays. Clear glass reflects by Fresnel's
// equations however small its k_s, except at k_s = 0, which allows glass without reflection.
//
// a, the consistency of the normals in the pixel (surface_point.h), multiplies k_s (rtrgs) or k (layered): where the normals of
// a pixel's surfels differ, at the rim of a mirror, the ray along the mean normal hits unrelated surfaces. Without a
// reflection, w_r is zero and F counts as 0 (layered: k = 0); without a transmission tau counts as 0.
#pragma once

#include "core/render/model/kernels/fresnel.h"

namespace vitrine {

enum class LayerBlend : unsigned char { RtrGs, Layered };

// Specular and transmission weights below one step of an 8-bit display send no rays.
inline constexpr double kMinSpecular = 1.0 / 255.0;
// Fresnel has full weight from this specular weight on.
inline constexpr double kFullFresnel = 0.05;
// The same for clear glass.
inline constexpr double kFullClear = 0.001;

template <class T>
struct BlendMaterial {  // or its gradient
  Vec3<T> f0{};
  T specular{}, transmission{}, cosine{}, agreement{1};  // k_s, tau, n.v, a
  bool coat = false;                                     // Fresnel has full weight whatever k_s; no gradient
  bool solid = false;                                    // clear means one wall of solid glass; no gradient
};

template <class T>
struct LayerWeights {  // or their gradients
  Vec3<T> diffuse{}, reflection{}, transmission{};
};

struct LayersPresent {
  bool reflection = false, transmission = false;
};

template <class T>
T fresnel_gate(const T& specular) {
  const T x = (specular - T(kMinSpecular)) / T(kFullFresnel - kMinSpecular);
  if (!(x > T(0))) return T(0);
  return x < T(1) ? x * (T(2) - x) : T(1);
}
template <class T>
T fresnel_gate_slope(const T& specular) {
  const T span(kFullFresnel - kMinSpecular), x = (specular - T(kMinSpecular)) / span;
  return x > T(0) && x < T(1) ? T(2) * (T(1) - x) / span : T(0);
}

template <class T>
T clear_gate(const T& specular) {
  const T x = specular / T(kFullClear);
  return x < T(1) ? x * x * (T(3) - T(2) * x) : T(1);
}
template <class T>
T clear_gate_slope(const T& specular) {
  const T x = specular / T(kFullClear);
  return x < T(1) ? T(6) * x * (T(1) - x) / T(kFullClear) : T(0);
}

template <class T>
LayerWeights<T> layer_weights(LayerBlend blend, const BlendMaterial<T>& m, LayersPresent present) {
  LayerWeights<T> w;
  const T tau = present.transmission ? m.transmission : T(0), one(1);
  const Fresnel<T> f = present.reflection ? fresnel(m.f0, m.cosine, tau, m.solid) : Fresnel<T>{};
  const T opaque_gate = m.coat ? one : fresnel_gate(m.specular);
  const T gate = opaque_gate + (one - opaque_gate) * tau * clear_gate(m.specular);
  for (size_t c = 0; c < 3; ++c) {
    if (blend == LayerBlend::RtrGs) {
      const T k_s = m.agreement * m.specular;
      w.diffuse[c] = one - k_s;
      w.reflection[c] = k_s * f.value[c];
      w.transmission[c] = k_s * tau * (one - f.value[c]);
    } else {
      const T k = present.reflection ? m.agreement * (m.specular + (one - m.specular) * gate * f.value[c]) : T(0);
      w.diffuse[c] = (one - k) * (one - tau);
      w.reflection[c] = k;
      w.transmission[c] = (one - k) * tau;
    }
  }
  return w;
}

// Gradient of the material; zero for inactive members.
template <class T>
BlendMaterial<T> layer_weights_vjp(LayerBlend blend, const BlendMaterial<T>& m, LayersPresent present, const LayerWeights<T>& g) {
  BlendMaterial<T> out;
  out.agreement = T(0);
  const T tau = present.transmission ? m.transmission : T(0), one(1), a = m.agreement;
  const Fresnel<T> f = present.reflection ? fresnel(m.f0, m.cosine, tau, m.solid) : Fresnel<T>{};
  const T opaque_gate = m.coat ? one : fresnel_gate(m.specular), opaque_slope = m.coat ? T(0) : fresnel_gate_slope(m.specular);
  const T closed = one - opaque_gate, clear = clear_gate(m.specular);
  const T gate = opaque_gate + closed * tau * clear;
  const T gate_slope = opaque_slope * (one - tau * clear) + closed * tau * clear_gate_slope(m.specular);
  Vec3<T> grad_f{};
  T grad_tau(0);
  for (size_t c = 0; c < 3; ++c) {
    const T F = f.value[c];
    if (blend == LayerBlend::RtrGs) {
      const T grad_k_s = -g.diffuse[c] + F * g.reflection[c] + tau * (one - F) * g.transmission[c];
      out.specular += a * grad_k_s;
      out.agreement += m.specular * grad_k_s;
      grad_f[c] = a * m.specular * (g.reflection[c] - tau * g.transmission[c]);
      grad_tau += a * m.specular * (one - F) * g.transmission[c];
    } else {
      const T full = present.reflection ? m.specular + (one - m.specular) * gate * F : T(0), k = a * full;
      const T grad_k = g.reflection[c] - (one - tau) * g.diffuse[c] - tau * g.transmission[c];
      grad_tau += (one - k) * (g.transmission[c] - g.diffuse[c]);
      if (!present.reflection) continue;
      out.specular += a * grad_k * (one - gate * F + (one - m.specular) * gate_slope * F);
      out.agreement += grad_k * full;
      grad_f[c] = a * grad_k * (one - m.specular) * gate;
      grad_tau += a * grad_k * (one - m.specular) * closed * clear * F;
    }
  }
  if (present.reflection) fresnel_vjp(m.f0, f, grad_f, out.f0, out.cosine, grad_tau);
  if (present.transmission) out.transmission = grad_tau;
  return out;
}

}  // namespace vitrine
