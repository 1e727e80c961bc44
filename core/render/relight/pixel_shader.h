// Shades one pixel of a relit picture. Each sample traces one ray to the environment, one to each area lamp and one into the
// material's lobe, combined by the balance heuristic (README 2).
#pragma once

#include "core/foundation/math/vec.h"
#include "core/render/relight/lit_scene.h"
#include "core/render/relight/microfacet.h"
#include "core/render/relight/sample_points.h"

namespace vitrine {

inline constexpr uint32_t kLightPlane = 0, kLobePlane = 1, kChoicePlane = 2, kLampPlane = 3;  // of the sample points

// Marks this nearly along the normal (squared sine) have no direction on the surface.
inline constexpr float kLeastMarks = 1e-4f;

// Shading frame: z is the normal.
struct ShadingFrame {
  Vec3f t0, t1, n;
  explicit ShadingFrame(const Vec3f& normal) : n(normal) { tangents(normal, t0, t1); }
  // t1 runs along the marks of brushed metal.
  ShadingFrame(const Vec3f& normal, const Vec3f& marks) : ShadingFrame(normal) {
    const Vec3f across = cross(marks, normal);
    if (!(squared_length(across) > kLeastMarks * squared_length(marks))) return;
    t0 = normalized(across), t1 = cross(normal, t0);
  }
  Vec3f local(const Vec3f& v) const { return {dot(v, t0), dot(v, t1), dot(v, n)}; }
  Vec3f world(const Vec3f& v) const { return v.x * t0 + v.y * t1 + v.z * n; }
};

// One pixel under the lighting, without transmitted light.
class PixelShader {
 public:
  PixelShader(const LitScene& lit, const Microfacet& scatter, const ShadingFrame& frame, const Vec3f& place, const Vec3f& origin)
      : lit_(lit), light_(lit.lighting()), scatter_(scatter), frame_(frame), place_(place), origin_(origin) {}

  Vec3f shade(const SamplePoints& points, int samples) const {
    if (!scatter_.scatters()) return {};
    Vec3f sum{};
    for (uint32_t i = 0; i < static_cast<uint32_t>(samples); ++i) {
      if (!light_.environment.black()) sum += towards_environment(points.point(kLightPlane, i));
      for (size_t lamp = light_.sharp_lamps(); lamp < light_.lamps(); ++lamp)
        sum += towards_lamp(lamp, points.point(kLampPlane + static_cast<uint32_t>(lamp), i));
      sum += along_lobe(points.point(kLobePlane, i), points.point(kChoicePlane, i).x);
    }
    sum = sum / float(samples);
    for (size_t lamp = 0; lamp < light_.sharp_lamps(); ++lamp) sum += towards_lamp(lamp, {});
    return sum;
  }

 private:
  float visibility(const Vec3f& direction, float far = Lighting::kFar) const {
    return lit_.surface().visibility(origin_, direction, far);
  }
  // Stops at the lamp: a surface such as the ceiling may lie behind it.
  float visibility(const LampSample& s) const {
    if (!(s.distance < Lighting::kFar)) return visibility(s.direction);
    const Vec3f way = place_ + s.distance * s.direction - origin_;
    const float distance = length(way);
    return distance > 0 ? visibility(way / distance, distance) : 1.f;
  }
  // Balance heuristic (Veach and Guibas 1995): radiance f cos / pdf with weight pdf / (pdf + other).
  Vec3f towards_environment(const Vec2f& u) const {
    const Environment::Sample s = light_.environment.sample(u);
    const Vec3f l = frame_.local(s.direction);
    if (!(l.z > 0)) return {};
    const Vec3f f = scatter_.value(l);
    return (visibility(s.direction) / (s.pdf + scatter_.pdf(l))) * hadamard(f, s.radiance);
  }
  Vec3f towards_lamp(size_t lamp, const Vec2f& u) const {
    const LampSample s = light_.sample_lamp(lamp, place_, u);
    if (!(s.pdf > 0)) return {};
    const Vec3f l = frame_.local(s.direction);
    if (!(l.z > 0)) return {};
    const float other = lamp < light_.sharp_lamps() ? 0.f : scatter_.pdf(l);
    return (visibility(s) / (s.pdf + other)) * hadamard(scatter_.value(l), s.radiance);
  }
  Vec3f along_lobe(const Vec2f& u, float choice) const {
    const Vec3f l = scatter_.sample(choice, u);
    const float pdf = scatter_.pdf(l);
    if (!(l.z > 0 && pdf > 0)) return {};
    const Vec3f d = frame_.world(l);
    const LitScene::Arrival a = lit_.arriving(origin_, d);
    Vec3f radiance = a.from_scene / pdf;
    if (a.from_outside > 0 && !light_.environment.black())
      radiance += (a.from_outside / (pdf + light_.environment.pdf(d))) * light_.environment.radiance(d);
    for (size_t lamp = light_.sharp_lamps(); lamp < light_.lamps(); ++lamp) {
      const AreaLight& area = light_.areas[lamp - light_.sharp_lamps()];
      const auto t = area.hit(origin_, d);
      if (!t) continue;
      const float area_pdf = *t * *t / (-dot(d, area.normal) * area.area());
      radiance += (visibility(d, *t) / (pdf + area_pdf)) * area.radiance;
    }
    return hadamard(scatter_.value(l), radiance);
  }

  const LitScene& lit_;
  const Lighting& light_;
  const Microfacet& scatter_;
  const ShadingFrame& frame_;
  Vec3f place_, origin_;  // rays start slightly above the place
};

}  // namespace vitrine
