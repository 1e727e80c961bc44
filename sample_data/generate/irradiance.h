// Irradiance at the vertices of the diffuse parts: solved once per lighting, shared by all views, interpolated in the triangle.
// Direct light comes from sampled lamps and sky; then each pass gathers, over the hemisphere, what the last pass left around:
//   E_0(v) = direct,   E_k+1(v) = E_0(v) + integral over wi of  albedo/pi E_k(hit of wi) cos  d wi
// The cells of the parts decide how sharp a shadow can be.
#pragma once

#include <vector>

#include "sample_data/generate/ray_scene.h"

namespace vitrine::generate {

class IrradianceCache {
 public:
  explicit IrradianceCache(const Scene& scene);  // all zero

  Vec3f irradiance(const Hit& hit) const { return interpolated(direct_, hit) + interpolated(indirect_, hit); }

 private:
  using Field = std::vector<std::vector<Vec3f>>;  // [part][vertex]
  static Vec3f interpolated(const Field& field, const Hit& hit) {
    const std::vector<Vec3f>& e = field[hit.part_index];
    return hit.barycentric.x * e[hit.vertices[0]] + hit.barycentric.y * e[hit.vertices[1]] +
           hit.barycentric.z * e[hit.vertices[2]];
  }
  Field direct_, indirect_;
  friend class Integrator;
};

}  // namespace vitrine::generate
