// Rays against a scene (Embree, single rays). Opaque parts and glass live in two trees: a shadow ray first asks the opaque
// one whether it is blocked, and only then multiplies the transmittances of the panes on its way; leaving the glass tree out
// is the scene without its glass.
#pragma once

#include <memory>
#include <optional>

#include "sample_data/generate/scene.h"

namespace vitrine::generate {

struct Hit {
  const Part* part = nullptr;
  size_t part_index = 0;
  std::array<uint32_t, 3> vertices{};
  Vec3f barycentric;  // weights of the three vertices
  float distance = 0;
  Vec3f position;
  Vec3f geometric;  // unit, outwards
  Vec3f normal;     // interpolated, unit, outwards
  Vec2f uv;
  bool glass() const { return part->material.glass(); }
};

class RayScene {
 public:
  explicit RayScene(const Scene& scene);  // keeps a reference
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  const Scene& scene() const { return scene_; }
  bool has_content() const;
  std::optional<Hit> first_hit(const Vec3f& origin, const Vec3f& direction, bool with_glass = true) const;
  // 0 when something opaque lies within `distance`, else the product of 1 - r over the panes passed (straight on: light that
  // solid glass gathers or spreads is left out), weakened by the content of the bodies passed.
  float transmittance(const Vec3f& origin, const Vec3f& direction, float distance, bool with_glass = true) const;
  // Of the contents alone, from outside of them to the first opaque surface; solid glass bends the ray, reflections are left out.
  float content_transmittance(const Vec3f& origin, const Vec3f& direction) const;
  // What fills the body that `point` is in, which must be closed or stand on something opaque; null: nothing.
  const GlassContent* content_at(const Vec3f& point) const;

 private:
  struct Trees;
  const Scene& scene_;
  std::unique_ptr<Trees> trees_;
};

// Where a ray leaves the surface of `hit` towards `direction` without meeting it again.
Vec3f offset_origin(const Hit& hit, const Vec3f& direction);

}  // namespace vitrine::generate
