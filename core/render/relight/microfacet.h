// BSDF of a relit pixel: scattering of light from l towards the eye v, in a frame whose z axis is the normal.
//   f(v, l) = w_d albedo/pi + R(v.h) D G / (4 n.v n.l)      half vector h, GGX distribution D, Schlick-Smith G
//   (core/render/model/kernels)
// R and w_d are those of the training blend (core/render/model/kernels/layer_blend.h), with a normal consistency of 1
// (algorithms 7.2):
//   rtrgs    R(c) = k_s F(c)                      w_d = 1 - k_s                    w_t = k_s tau (1 - F(n.v))
//   layered  R(c) = k_s + (1 - k_s) g(k_s) F(c)   w_d = (1 - R(n.v)) (1 - tau)     w_t = (1 - R(n.v)) tau
// Brushed and turned metal is rougher across its marks, along the x axis of the frame (Burley 2012; KHR_materials_anisotropy):
// alpha_x = alpha + (1 - alpha) anisotropy^2, alpha_y = alpha,
//   D = 1 / (pi alpha_x alpha_y q^2),  q = hx^2/alpha_x^2 + hy^2/alpha_y^2 + hz^2 (Heitz 2014), G of the alpha along v and l.
// Directions are sampled from a mixture of cosine-weighted directions and visible-normal reflections (spherical caps, Dupuy and
// Benyoub 2023):  pdf = (1 - p) n.l/pi + p D G1(v) / (4 n.v), with the exact Smith G1 (Heitz 2014).
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/render/model/kernels/ggx.h"
#include "core/render/model/kernels/layer_blend.h"
#include "core/render/model/kernels/surface_point.h"

namespace vitrine {

struct RelitMaterial {
  Vec3f albedo{}, f0{};
  float roughness = 1, specular = 0, transmission = 0;  // specular = k_s, transmission = tau
  float anisotropy = 0;                                 // of brushed metal, in [0, 1]
  float agreement = 1;  // consistency of the normals blended in a pixel (core/render/model/README.md 4)
};

// Weights of scattering, reflection and transmission at this cosine.
inline LayerWeights<float> relit_weights(LayerBlend blend, const RelitMaterial& m, float cosine) {
  return layer_weights<float>(blend, {m.f0, m.specular, m.transmission, cosine, m.agreement},
                              {.reflection = true, .transmission = true});
}

class Microfacet {
 public:
  static constexpr float kPi = std::numbers::pi_v<float>;

  // `view`: unit, z > 0.
  Microfacet(LayerBlend blend, const RelitMaterial& m, const Vec3f& view) : blend_(blend), m_(m), view_(view) {
    alpha_ = std::max(m.roughness, float(kMinRoughness));
    alpha_ *= alpha_;
    across_ = alpha_ + (1 - alpha_) * m.anisotropy * m.anisotropy;
    const LayerWeights<float> w = relit_weights(blend, m, view.z);
    diffuse_ = hadamard(w.diffuse, m.albedo);
    transmission_ = w.transmission;
    const float specular = mean(w.reflection), diffuse = mean(diffuse_);
    specular_share_ = specular + diffuse > 0 ? specular / (specular + diffuse) : 0.f;
    // Bounds the probabilities, so that single samples have no extreme weights.
    if (specular_share_ > 0 && diffuse > 0) specular_share_ = std::clamp(specular_share_, 0.1f, 0.9f);
  }

  const Vec3f& transmission_weight() const { return transmission_; }
  bool scatters() const { return mean(diffuse_) > 0 || specular_share_ > 0; }

  // f(v, l) n.l
  Vec3f value(const Vec3f& l) const {
    if (!(l.z > 0)) return {};
    Vec3f out = (l.z / kPi) * diffuse_;
    if (specular_share_ > 0) {
      const Vec3f h = normalized(view_ + l);
      const float nv = std::max(view_.z, float(kMinCosine));
      const float lobe =
          distribution(h) * smith_g1(nv, 0.5f * alpha_along(view_)) * smith_g1(l.z, 0.5f * alpha_along(l)) / (4 * nv);
      out += lobe * relit_weights(blend_, m_, dot(view_, h)).reflection;
    }
    return out;
  }
  float pdf(const Vec3f& l) const {
    if (!(l.z > 0)) return 0;
    float p = (1 - specular_share_) * l.z / kPi;
    if (specular_share_ > 0) p += specular_share_ * mirror_pdf(normalized(view_ + l));
    return p;
  }
  // Samples a direction with density pdf(); z <= 0: below the surface, no light. `choice`, `u`: numbers in [0, 1).
  Vec3f sample(float choice, const Vec2f& u) const {
    if (choice < specular_share_) return reflected(view_, visible_normal(u));
    const float r = std::sqrt(u.x), phi = 2 * kPi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), std::sqrt(std::max(1 - u.x, 0.f))};
  }

 private:
  static float mean(const Vec3f& v) { return (v.x + v.y + v.z) / 3; }
  bool brushed() const { return across_ != alpha_; }
  float distribution(const Vec3f& h) const {
    if (!brushed()) return ggx_distribution(alpha_, h.z).value;
    const float x = h.x / across_, y = h.y / alpha_, q = x * x + y * y + h.z * h.z;
    return 1 / (kPi * across_ * alpha_ * q * q);
  }
  float alpha_along(const Vec3f& d) const {
    if (!brushed()) return alpha_;
    const float x2 = d.x * d.x, y2 = d.y * d.y;
    return x2 + y2 > 0 ? std::sqrt((x2 * across_ * across_ + y2 * alpha_ * alpha_) / (x2 + y2)) : alpha_;
  }
  float mirror_pdf(const Vec3f& h) const {
    const float nv = std::max(view_.z, float(kMinCosine)), along = alpha_along(view_), a2 = along * along;
    const float g1_over_nv = 2 / (nv + std::sqrt(a2 + (1 - a2) * nv * nv));
    return 0.25f * g1_over_nv * distribution(h);
  }
  Vec3f visible_normal(const Vec2f& u) const {
    const Vec3f v = normalized(Vec3f{across_ * view_.x, alpha_ * view_.y, view_.z});
    const float phi = 2 * kPi * u.x, z = (1 - u.y) * (1 + v.z) - v.z, s = std::sqrt(std::clamp(1 - z * z, 0.f, 1.f));
    const Vec3f h = Vec3f{s * std::cos(phi), s * std::sin(phi), z} + v;
    return normalized(Vec3f{across_ * h.x, alpha_ * h.y, h.z});
  }

  LayerBlend blend_;
  RelitMaterial m_;
  Vec3f view_, diffuse_{}, transmission_{};
  float alpha_, across_, specular_share_ = 0;
};

constexpr float kTypicalCosine = 0.7f;

// Approximate albedo of the diffuse part over all directions.
inline Vec3f scattered_reflectance(LayerBlend blend, const RelitMaterial& m) {
  return hadamard(relit_weights(blend, m, kTypicalCosine).diffuse, m.albedo);
}
// Approximate total reflectance, for bounces between surfaces.
inline Vec3f bounce_reflectance(LayerBlend blend, const RelitMaterial& m) {
  const LayerWeights<float> w = relit_weights(blend, m, kTypicalCosine);
  const Vec3f out = hadamard(w.diffuse, m.albedo) + w.reflection;
  return {std::min(out.x, 1.f), std::min(out.y, 1.f), std::min(out.z, 1.f)};
}
// Share of light transmitted without deflection.
inline float straight_transmittance(LayerBlend blend, const RelitMaterial& m) {
  const Vec3f t = relit_weights(blend, m, kTypicalCosine).transmission;
  return (t.x + t.y + t.z) / 3;
}

}  // namespace vitrine
