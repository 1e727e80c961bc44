// Scene under one lighting. The outgoing radiance of every mesh vertex is computed once; rays look it up.
//   E(x) = sum of samples  L V n.l / pdf  (environment by its luminance, lamps)  +  light from the scene by cosine-weighted rays
//   E'(x) = E(x), or that of the places around x where light scatters below the surface (subsurface.h)
//   B(x) = reflectance E' / pi                radiance of the mesh as a diffuse surface, iterated for the bounces
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/render/relight/scene_surface.h"
#include "core/scene/light/lighting.h"

namespace vitrine {

struct LitSceneDesc {
  int light_samples = 64;  // per vertex, of the environment and of each area lamp
  int gather_rays = 32;    // per vertex, for light from the rest of the scene
  int bounces = 3;
  uint64_t seed = 1;
};

class LitScene {
 public:
  // Both must outlive this object.
  LitScene(const SceneSurface& surface, const Lighting& lighting, const LitSceneDesc& desc = {});

  const SceneSurface& surface() const { return *surface_; }
  const Lighting& lighting() const { return *lighting_; }
  const std::vector<Vec3f>& irradiance() const { return irradiance_; }  // [v] E'
  const std::vector<Vec3f>& radiance() const { return radiance_; }      // [v] B

  // Light along a ray: from the mesh, and the share from outside the scene.
  struct Arrival {
    Vec3f from_scene{};
    float from_outside = 1;
  };
  Arrival arriving(const Vec3f& origin, const Vec3f& direction) const;
  // Mean incident radiance over all directions at a point in free space, lamps included (algorithms 7.4).
  Vec3f fluence(const Vec3f& point, uint64_t stream, int samples) const;
  // Irradiance / pi of one side of a patch in free space. `blocked(direction)`: occluders outside this scene.
  using Blocked = std::function<bool(const Vec3f& direction)>;
  struct Patch {
    Vec3f point, normal;
  };
  Vec3f irradiance_in_the_open(const Patch& patch, const Blocked& blocked, uint64_t stream, int samples) const;

 private:
  // Calls take(direction, radiance) for samples of the light at a point; the radiances sum to the fluence.
  template <class Take>
  void sample_arriving(const Vec3f& point, uint64_t stream, int samples, const Take& take) const;
  std::vector<Vec3f> direct_irradiance() const;
  void bounce(const std::vector<Vec3f>& direct);
  void smooth(std::vector<Vec3f>& per_vertex) const;

  const SceneSurface* surface_;
  const Lighting* lighting_;
  LitSceneDesc desc_;
  std::vector<Vec3f> irradiance_, radiance_;
};

}  // namespace vitrine
