// What is seen through the glass of a scene, under another light (README 5): the opaque surfels of the diffuse layer with the
// light that their place on the mesh sends on, and the transmittance layer, whose trained colours are scaled by the light there
// now over the light there then. Rasterised together from the pixel's own camera: a thin pane bends no rays
// (core/model/thin_glass_pass.h). Scenes that were trained with Glass::Traced show the transmittance layer alone.
#pragma once

#include <memory>
#include <vector>

#include "core/relight/lit_scene.h"
#include "core/render/renderer.h"

namespace vitrine {

class GlassContent {
 public:
  // All must live as long as this.
  GlassContent(const RelitScene& scene, const SceneSurface& surface);
  bool empty() const { return scene_->trained.surfels.transmittance.size() == 0; }

  void relight(const LitScene& lit, const LitSceneDesc& desc);
  struct Picture {
    RasterImages images;
    Vec3f radiance(uint32_t pixel) const {
      const auto color = images.plane(Aov::Color);
      const size_t n = color.size() / 3;
      return {color[pixel], color[n + pixel], color[2 * n + pixel]};
    }
    float inner_transmittance(uint32_t pixel) const { return 1 - images.plane(Aov::Alpha)[pixel]; }
  };
  const Picture& picture(const View& view);

 private:
  std::vector<Vec3f> fluence(const LitScene& lit) const;  // [surfels of the transmittance layer]
  Vec3f matt_radiance(const LitScene& lit, size_t surfel) const;

  const RelitScene* scene_;
  const SceneSurface* surface_;
  std::vector<uint32_t> opaque_;  // of the diffuse layer
  SplatLayer merged_;             // those, then the transmittance layer
  std::vector<Vec3f> fluence_before_;
  std::unique_ptr<Renderer> renderer_;
  Picture picture_;
};

}  // namespace vitrine
