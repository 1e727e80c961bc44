// What is seen through the glass of a scene, under another light (README 5): the opaque surfels of the diffuse layer with the
// light that their place on the mesh scatters, and the transmittance layer: its albedo in the light that reaches it through the
// panes, past what stands behind them; where no albedo is known, its trained colours, scaled by the light there now over the
// light there then. Rasterised together from the pixel's own camera: a thin pane bends no rays
// (core/model/thin_glass_pass.h). What mirrors behind it is a surface to be shaded like any other. Where glass is thick, rays
// that it bends are sent through the same surfels (core/model/bent_rays.h), and what mirrors there looks matt. Scenes that were
// trained with Glass::Traced show the transmittance layer alone.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/model/bent_rays.h"
#include "core/model/gbuffer.h"
#include "core/relight/lit_place.h"
#include "core/relight/lit_scene.h"
#include "core/render/renderer.h"

namespace vitrine {

class GlassContent {
 public:
  // All must live as long as this.
  GlassContent(const RelitScene& scene, const SceneSurface& surface);
  bool empty() const { return merged_.size() == 0; }

  void relight(const LitScene& lit, const LitSceneDesc& desc);
  // `frame`: the diffuse pass of the view to be seen; `asking`: its pixels whose rays thick glass may bend.
  void look(const Frame& frame, std::span<const uint32_t> asking);
  // Of a pixel of that view. What is left of the ray, `rest`, goes on from `origin` to what stands behind all surfels.
  struct Seen {
    Vec3f radiance{};
    float rest = 0;
    Vec3f origin{}, direction{};
  };
  // `origin`, `direction`: of the ray that goes straight on behind the glass.
  Seen seen(uint32_t pixel, const Vec3f& origin, const Vec3f& direction) const;
  // What mirrors there, without what it scatters, which seen() has; nullopt: nothing does. `ray`: of the pixel.
  std::optional<ShownSurface> gloss(uint32_t pixel, const PixelRay<float>& ray) const;

 private:
  std::vector<Vec3f> fluence(const LitScene& lit) const;  // [surfels of the transmittance layer]; zero where the albedo is known
  Vec3f arriving_at(const LitScene& lit, size_t surfel) const;
  bool knows_albedo(size_t inside) const;  // of a surfel of the transmittance layer
  Vec3f arriving_inside(const LitScene& lit, size_t inside) const;

  const RelitScene* scene_;
  const SceneSurface* surface_;
  std::vector<uint32_t> opaque_;    // of the diffuse layer
  SplatLayer merged_;               // those, then the transmittance layer, with the materials of a diffuse layer
  SplatLayer matt_;                 // the same for bent rays, which shade no mirrors; empty: no glass is thick
  std::optional<MeshHits> things_;  // RelitScene::behind_glass
  Vec3f middle_{};                  // of the transmittance layer
  std::vector<Vec3f> fluence_before_;
  std::unique_ptr<Renderer> renderer_;
  Frame picture_;                   // of merged_: its diffuse channels
  std::optional<GBuffer> content_;  // the same, pixel by pixel
  std::unique_ptr<Tracer> tracer_;  // of matt_, as it is lit; null: not built yet
  BentLegs legs_;
  RayValues leg_values_;
  std::vector<uint32_t> bent_;  // [h,w] 1 + place in legs_.pixels; 0: straight. Empty: no glass is thick
};

}  // namespace vitrine
