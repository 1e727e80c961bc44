// The albedo that a trained scene shows, as a picture: of the diffuse layer, and in pixels of clear glass of what stands behind
// it (core/model/opened_scene.h), as far as they are clear.
#pragma once

#include <optional>

#include "core/picture/decomposed_materials.h"
#include "core/picture/surfel_colors.h"
#include "core/picture/trained_scene.h"

namespace vitrine {

class AlbedoPainter {
 public:
  // `materials`: of this scene. Without an albedo of what stands behind glass, its glass is as opaque as anything.
  AlbedoPainter(const SplatScene& scene, const ImageOptions& image, const DecomposedMaterials& materials);
  // [h, w, 3] at the size of the view's intrinsics, linear; 0 where there is no surface.
  ImageF picture(const View& view);

 private:
  std::optional<SurfelColors> first_, clear_;  // of the first surfaces: albedo, transmission in all channels
  std::optional<SurfelColors> behind_;         // everything but the glass
};

}  // namespace vitrine
