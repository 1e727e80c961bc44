// The path tracer. From the camera a path runs over mirrors, metal, coats and glass (both branches of the first panes and coats
// are followed, later ones by chance) until it ends on a diffuse surface or the base of a coat. Its light comes from the
// irradiance cache or, without one, from sampled lamps and sky (one shadow ray each) and a cosine-distributed bounce: slow and
// noisy, but free of the cache's grid, so it is what the tests compare with. Metal and rough coats use light and lobe samples
// with the power heuristic. Left out: caustics, i.e. light that reaches a diffuse surface over a mirror, metal or the reflection
// in glass.
#pragma once

#include <span>

#include "sample_data/generate/irradiance.h"
#include "sample_data/generate/medium.h"
#include "sample_data/generate/ray_scene.h"
#include "sample_data/generate/sampler.h"

namespace vitrine::generate {

struct Illumination {
  const Environment& environment;
  std::span<const Lamp> lamps;     // empty: the lamps are off
  bool glass = true;               // false: the scene with its glass taken away
  const Medium* medium = nullptr;  // before the camera; nullptr: air
};

class Integrator {
 public:
  Integrator(const RayScene& rays, const Illumination& light) : rays_(rays), light_(light) {}

  using CacheDesc = generate::CacheDesc;
  void solve_irradiance(IrradianceCache& cache, const CacheDesc& desc) const;

  // Radiance towards the origin of the ray. `cache` may be null: plain path tracing up to kBounces diffuse bounces.
  Vec3f radiance(const Vec3f& origin, const Vec3f& direction, const IrradianceCache* cache, Sampler& sampler) const;

  static constexpr int kBounces = 5;
  const RayScene& rays() const { return rays_; }

 private:
  struct Branch {
    Vec3f origin, direction, weight{1, 1, 1};
    int depth = 0;
    bool lights = true;   // false after a diffuse surface: lamps and sky were counted there
    float lobe_pdf = -1;  // > 0: the direction was drawn from a lobe with this density
    const GlassContent* within = nullptr;
  };
  struct LightSample {
    Vec3f direction, radiance;  // radiance includes the shadow
    float pdf = 0;
  };
  // `inside` (may be null) is set when the path ends on the inner side of a surface.
  Vec3f traced(const Branch& start, const IrradianceCache* cache, Sampler& sampler, bool* inside = nullptr) const;
  void gather_part(size_t part, int pass, const CacheDesc& desc, const IrradianceCache& last, std::vector<Vec3f>& next) const;
  LightSample sky_sample(const Hit& hit, const Vec3f& side, Sampler& sampler) const;
  LightSample lamp_sample(const Hit& hit, const Vec3f& side, Sampler& sampler) const;
  float lamp_pdf(size_t lamp, const Vec3f& direction, float distance) const;
  Vec3f direct_irradiance(const Hit& hit, Sampler& sampler) const;
  Vec3f lobe_direct(const Hit& hit, const Frame& frame, const Vec3f& wo, Sampler& sampler) const;
  // The reflected way of a path: false where there is none.
  bool follow_lobe(const Hit& hit, Branch& path, Vec3f& sum, Sampler& sampler) const;
  bool follow_coat(const Hit& hit, Branch& path, Vec3f& sum, Sampler& sampler) const;

  const RayScene& rays_;
  Illumination light_;
};

}  // namespace vitrine::generate
