#include "sample_data/generate/material.h"

#include <algorithm>
#include <cmath>

namespace vitrine::generate {
namespace {

float alpha_of(const Material& material) { return std::max(material.roughness * material.roughness, 1e-3f); }

float ggx_density(const Vec3f& h, float alpha) {
  const float t = (h.x * h.x + h.y * h.y) / (alpha * alpha) + h.z * h.z;
  return 1.0f / (kPi * alpha * alpha * t * t);
}

float smith_lambda(const Vec3f& w, float alpha) {
  return 0.5f * (std::sqrt(1.0f + alpha * alpha * (w.x * w.x + w.y * w.y) / (w.z * w.z)) - 1.0f);
}

// Visible normals of GGX (Heitz 2018).
Vec3f visible_normal(const Vec3f& wo, float alpha, const Vec2f& u) {
  const Vec3f v = normalized(Vec3f{alpha * wo.x, alpha * wo.y, wo.z});
  const float across = v.x * v.x + v.y * v.y;
  const Vec3f t1 = across > 0 ? (1.0f / std::sqrt(across)) * Vec3f{-v.y, v.x, 0} : Vec3f{1, 0, 0};
  const Vec3f t2 = cross(v, t1);
  const float r = std::sqrt(u.x), phi = 2.0f * kPi * u.y;
  const float p1 = r * std::cos(phi), s = 0.5f * (1.0f + v.z);
  const float p2 = (1.0f - s) * std::sqrt(1.0f - p1 * p1) + s * r * std::sin(phi);
  const Vec3f n = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1.0f - p1 * p1 - p2 * p2)) * v;
  return normalized(Vec3f{alpha * n.x, alpha * n.y, std::max(1e-6f, n.z)});
}

// A coat reflects by the angle to its surface, not to the facet: what it leaves to the base is then exactly the rest.
Vec3f lobe_fresnel(const Material& material, float cos_surface, float cos_facet) {
  if (material.kind != MaterialKind::Coat) return schlick_fresnel(material.reflectance, cos_facet);
  return interface_reflectance(material.index_of_refraction, cos_surface) * Vec3f{1, 1, 1};
}

}  // namespace

float interface_reflectance(float relative_index, float cos_theta) {
  const float c = std::min(std::abs(cos_theta), 1.0f);
  const float sin_t = std::sqrt(1.0f - c * c) / relative_index;
  const float ct = std::sqrt(std::max(0.0f, 1.0f - sin_t * sin_t));
  const float s = (c - relative_index * ct) / (c + relative_index * ct);
  const float p = (relative_index * c - ct) / (relative_index * c + ct);
  return 0.5f * (s * s + p * p);
}

float sheet_reflectance(float index_of_refraction, float cos_theta) {
  const float R = interface_reflectance(index_of_refraction, cos_theta);
  return 2.0f * R / (1.0f + R);
}

Vec3f schlick_fresnel(const Vec3f& reflectance, float cos_theta) {
  const float m = std::clamp(1.0f - cos_theta, 0.0f, 1.0f);
  const float w = m * m * m * m * m;
  return (1.0f - w) * reflectance + w * Vec3f{1, 1, 1};
}

Frame::Frame(const Vec3f& normal) : n(normal) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z), c = n.x * n.y * a;
  t = {1.0f + sign * n.x * n.x * a, sign * c, -sign * n.x};
  b = {c, sign + n.y * n.y * a, -n.y};
}

Vec3f cosine_direction(const Vec2f& u) {
  const float r = std::sqrt(u.x), phi = 2.0f * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), std::sqrt(std::max(0.0f, 1.0f - u.x))};
}

LobeSample sample_lobe(const Material& material, const Vec3f& wo, const Vec2f& u) {
  const float alpha = alpha_of(material);
  const Vec3f h = visible_normal(wo, alpha, u);
  const Vec3f wi = 2.0f * dot(wo, h) * h - wo;
  if (wi.z <= 1e-5f) return {wi, {}, 0};
  const float lambda_o = smith_lambda(wo, alpha), lambda_i = smith_lambda(wi, alpha);
  const Vec3f F = lobe_fresnel(material, wo.z, dot(wi, h));
  return {wi, ((1.0f + lambda_o) / (1.0f + lambda_o + lambda_i)) * F, lobe_pdf(material, wo, wi)};
}

Vec3f lobe_brdf(const Material& material, const Vec3f& wo, const Vec3f& wi) {
  if (wi.z <= 1e-5f || wo.z <= 1e-5f) return {};
  const float alpha = alpha_of(material);
  const Vec3f h = normalized(wo + wi);
  const float g2 = 1.0f / (1.0f + smith_lambda(wo, alpha) + smith_lambda(wi, alpha));
  return (ggx_density(h, alpha) * g2 / (4.0f * wo.z * wi.z)) * lobe_fresnel(material, wo.z, dot(wi, h));
}

float lobe_pdf(const Material& material, const Vec3f& wo, const Vec3f& wi) {
  if (wi.z <= 1e-5f || wo.z <= 1e-5f) return 0;
  const float alpha = alpha_of(material);
  const Vec3f h = normalized(wo + wi);
  // D_visible / (4 wo.h) with D_visible = G1 D max(0, wo.h) / cos_o.
  return ggx_density(h, alpha) / ((1.0f + smith_lambda(wo, alpha)) * 4.0f * wo.z);
}

}  // namespace vitrine::generate
