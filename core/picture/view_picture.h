// One view of a trained scene as pictures: what its photo would show, the surface below, and the layers that the picture is
// made of. Used by the evaluation and by `vitrine render`, so that both show the same thing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/camera/view.h"
#include "core/image/exr.h"
#include "core/model/layered_model.h"
#include "core/picture/trained_scene.h"

namespace vitrine {

// A map of floats in the channels' usual names: R G B (linear radiance, before the view's gain), X Y Z (world), Z (depth), Y.
//   radiance                              the whole picture
//   diffuse, reflection, transmission     what each layer adds to it, the opaque twin to the first; they sum up to `radiance`
//   reflected, transmitted                what the rays brought, before it was weighted
//   fresnel, specular_weight, transmission_weight, roughness      the materials
//   normal, depth                         the surface
// Layers that the scene does not have give no map.
struct PictureLayer {
  std::string name;  // "diffuse", "normal", ...
  ExrImage map;
};

struct ViewPicture {
  Intrinsics intrinsics;
  ImageF srgb;                       // [h, w, 3] display-referred, gain applied, clipped to [0,1]
  ImageF zdepth;                     // [h, w, 1]; 0 where alpha < 1/2
  ImageF normal_in_world;            // [h, w, 3], unit; 0 0 0 where alpha < 1/2
  std::vector<PictureLayer> layers;  // empty unless asked for

  const ImageF* layer(std::string_view name) const;  // nullptr: there is none
};

struct PictureDesc {
  Backend backend = Backend::Cpu;  // of the rasteriser; the reference also traces by the reference
  bool layers = false;
  int samples = 0;  // GGX rays of a rough pixel; 0 = the lobe that the scene was trained with
};

class ScenePainter {
 public:
  ScenePainter(TrainedScene scene, const PictureDesc& desc);
  // At the size of the view's intrinsics.
  ViewPicture picture(const View& view);
  const SplatScene& surfels() const { return scene_.surfels; }
  const ImageOptions& image() const { return scene_.image; }

 private:
  TrainedScene scene_;
  PictureDesc desc_;
  LayeredModel model_;
  Frame frame_;
};

}  // namespace vitrine
