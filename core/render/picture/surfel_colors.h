// Renders one colour per surfel (albedo, irradiance, roughness as grey) instead of the trained radiance, blended like the diffuse
// layer.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/trained_scene.h"
#include "core/render/raster/renderer.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// The surfels with view-independent colours, [surfels].
SplatLayer painted_layer(const SplatLayer& surfels, std::span<const Vec3f> colors);

class SurfelColors {
 public:
  // `colors`: one per surfel of `layer`, non-negative. `near_z`: that of the trained scene.
  SurfelColors(const SplatLayer& layer, std::span<const Vec3f> colors, float near_z);
  // [h, w, 3] at the size of the view's intrinsics: the blended colour divided by alpha; 0 where alpha < 1/2.
  ImageF picture(const View& view);

 private:
  SplatLayer layer_;
  float near_z_;
  std::unique_ptr<Renderer> renderer_;
  RasterImages images_;
};

// Renders the albedo of a trained scene: of the diffuse layer, and in pixels of clear glass of the scene behind it
// (core/render/model/opened_scene.h), weighted by their transmission.
class AlbedoPainter {
 public:
  // `materials`: of this scene. Without an albedo behind glass, the glass is treated as opaque.
  AlbedoPainter(const SplatScene& scene, const ImageOptions& image, const DecomposedMaterials& materials);
  // [h, w, 3] at the size of the view's intrinsics, linear; 0 where there is no surface.
  ImageF picture(const View& view);

 private:
  std::optional<SurfelColors> first_, clear_;  // of the first surfaces: albedo, transmission in all channels
  std::optional<SurfelColors> behind_;         // scene without glass
};

}  // namespace vitrine
