// How surfaces answer to light: diffuse (Lambert), metal (GGX microfacets, one Fresnel colour), mirror, a clear coat over paint,
// thin and solid glass, and emitters. Directions point away from the surface, cosines are against the unit normal n on the side
// of wo.
//   metal: f = F D G2 / (4 cos_i cos_o), Smith heights correlated, alpha = roughness^2 (Heitz 2014, 2018)
//   coat: a clear layer over a diffuse base; R(cos_o) is reflected, sharp or spread by the lobe of a metal of its roughness,
//         1 - R lights the base: albedo / pi. Reflection and base together never exceed 1
//   thin glass: a sheet without thickness; r = 2R/(1+R) sums both faces of a real pane, 1 - r goes straight through
//   solid glass: a closed surface; R is mirrored at every interface, 1 - R refracted (Snell)
#pragma once

#include <memory>

#include "core/foundation/math/vec.h"
#include "sample_data/generate/texture.h"

namespace vitrine::generate {

class GlassContent;  // content.h

enum class MaterialKind { Diffuse, Metal, Mirror, Coat, ThinGlass, SolidGlass, Emitter };

struct Material {
  MaterialKind kind = MaterialKind::Diffuse;
  Texture albedo = {};                               // Diffuse, Coat (its base)
  Vec3f reflectance{1, 1, 1};                        // Metal, Mirror: at normal incidence
  float roughness = 0;                               // Metal, Coat: perceptual, alpha = roughness^2; a coat of 0 is a mirror
  float index_of_refraction = 1.5f;                  // Coat, ThinGlass, SolidGlass
  std::shared_ptr<const GlassContent> content = {};  // of glass: what fills it; null: clear
  bool glass() const { return kind == MaterialKind::ThinGlass || kind == MaterialKind::SolidGlass; }
  bool painted() const { return kind == MaterialKind::Diffuse || kind == MaterialKind::Coat; }  // has an albedo
  bool glossy() const { return kind != MaterialKind::Diffuse && kind != MaterialKind::Emitter; }
};

// R of one interface, unpolarised; `relative_index`: behind over in front. 1 where all is reflected.
float interface_reflectance(float relative_index, float cos_theta);
float sheet_reflectance(float index_of_refraction, float cos_theta);
Vec3f schlick_fresnel(const Vec3f& reflectance, float cos_theta);

struct Frame {  // an orthonormal basis around n (Duff et al. 2017)
  Vec3f t, b, n;
  explicit Frame(const Vec3f& normal);
  Vec3f world(const Vec3f& local) const { return local.x * t + local.y * b + local.z * n; }
  Vec3f local(const Vec3f& world) const { return {dot(world, t), dot(world, b), dot(world, n)}; }
};

Vec3f cosine_direction(const Vec2f& u);  // local, pdf = z / pi

struct LobeSample {
  Vec3f wi;      // local
  Vec3f weight;  // f cos / pdf; zero when the direction leaves below the surface
  float pdf = 0;
};
// The reflecting lobe of a metal or of a rough coat. Local directions, z along the normal.
LobeSample sample_lobe(const Material& material, const Vec3f& wo, const Vec2f& u);
Vec3f lobe_brdf(const Material& material, const Vec3f& wo, const Vec3f& wi);
float lobe_pdf(const Material& material, const Vec3f& wo, const Vec3f& wi);

}  // namespace vitrine::generate
