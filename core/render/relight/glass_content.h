// Content seen through glass under another light (README 5). Opaque surfels of the diffuse layer get the light scattered by the
// mesh at their position. Surfels of the transmittance layer get their albedo times the light that arrives through the panes,
// with occlusion by the mesh behind glass; without an albedo their trained colours are scaled by the ratio of new to old light.
// Both are rasterised together from the pixel's camera, since thin panes do not bend rays (core/render/model/thin_glass_pass.h).
// Mirrors behind glass are shaded as surfaces. Rays bent by thick glass are traced through the same surfels
// (core/render/model/bent_rays.h); mirrors look diffuse there. Scenes trained with Glass::Traced show the transmittance layer
// only.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/render/model/bent_rays.h"
#include "core/render/model/gbuffer.h"
#include "core/render/relight/lit_place.h"
#include "core/render/relight/lit_scene.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

class GlassContent {
 public:
  // All arguments must outlive this object.
  GlassContent(const RelitScene& scene, const SceneSurface& surface);
  bool empty() const { return merged_.size() == 0; }

  void relight(const LitScene& lit, const LitSceneDesc& desc);
  // `frame`: diffuse pass of the view; `requesting`: pixels whose rays thick glass may bend.
  void look(const Frame& frame, std::span<const uint32_t> requesting);
  // Content in one pixel of that view. The share `rest` of the ray continues from `origin` behind all surfels.
  struct Seen {
    Vec3f radiance{};
    float rest = 0;
    Vec3f origin{}, direction{};
  };
  // `origin`, `direction`: the straight ray behind the glass.
  Seen seen(uint32_t pixel, const Vec3f& origin, const Vec3f& direction) const;
  // The specular surface behind the glass, without its scattered light, which seen() contains; nullopt if there is none. `ray`:
  // camera ray of the pixel.
  std::optional<ShownSurface> specular_surface(uint32_t pixel, const PixelRay<float>& ray) const;

 private:
  std::vector<Vec3f> fluence(const LitScene& lit) const;  // [surfels of the transmittance layer]; zero where the albedo is known
  Vec3f arriving_at(const LitScene& lit, size_t surfel) const;
  bool knows_albedo(size_t inside) const;  // `inside`: index in the transmittance layer
  Vec3f arriving_inside(const LitScene& lit, size_t inside) const;

  const RelitScene* scene_;
  const SceneSurface* surface_;
  std::vector<uint32_t> opaque_;          // indices in the diffuse layer
  SplatLayer merged_;                     // opaque_, then the transmittance layer, with materials of a diffuse layer
  SplatLayer matt_;                       // merged_ for bent rays, without specular shading; empty without thick glass
  std::optional<MeshHits> content_mesh_;  // RelitScene::behind_glass
  Vec3f middle_{};                        // centroid of the transmittance layer
  std::vector<Vec3f> fluence_before_;
  std::unique_ptr<Renderer> renderer_;
  Frame picture_;                   // diffuse channels of merged_
  std::optional<GBuffer> content_;  // the same per pixel
  std::unique_ptr<Tracer> tracer_;  // of matt_ with its current lighting; null: not built
  BentLegs legs_;
  RayValues leg_values_;
  std::vector<uint32_t> bent_;  // [h,w] 1 + index in legs_.pixels; 0: straight ray. Empty without thick glass
};

}  // namespace vitrine
