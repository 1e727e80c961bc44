// Renders one view of a trained scene: the picture, the surface below it, and its layers. Shared by evaluation and `vitrine
// render`, so that both agree.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/render/model/layered_model.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/exr.h"

namespace vitrine {

// A float map with the usual channel names: R G B (linear radiance, before the view's gain), X Y Z (world), Z (depth), Y.
//   radiance                              the whole picture
//   clear                                 the same without the water or haze of the photos; only if they have it
//   diffuse, reflection, transmission     contribution of each layer (the opaque twin counts as diffuse); their sum is
//   `radiance`,
//                                         or `clear`
//   reflected, transmitted                radiance of the rays before weighting
//   fresnel, specular_weight, transmission_weight, roughness      materials
//   normal, depth                         surface
// Layers that the scene lacks have no map.
struct PictureLayer {
  std::string name;  // "diffuse", "normal", ...
  ExrImage map;
};

struct ViewPicture {
  Intrinsics intrinsics;
  ImageF srgb;                       // [h, w, 3] display-referred, gain applied, clipped to [0,1]
  ImageF zdepth;                     // [h, w, 1]; 0 where alpha < 1/2
  ImageF normal_in_world;            // [h, w, 3], unit; 0 0 0 where alpha < 1/2
  std::vector<PictureLayer> layers;  // empty unless requested
  ImageF linear = {};                // [h, w, 3] radiance before the gain
  ImageF clear = {};                 // [h, w, 3] the same without the medium of the photos; empty without one

  const ImageF* layer(std::string_view name) const;  // nullptr if there is none
};

// Radiance as shown: times the gain, clipped to [0, 1], sRGB.
ImageF displayed(const ImageF& linear, const Vec3d& gain);

// The undistorted photo at render size: area average in linear light, encoded to sRGB and clipped to [0,1], the usual values for
// PSNR and SSIM.
ImageF photo_srgb(const std::filesystem::path& sfm_folder, const View& view, const Intrinsics& intrinsics);

struct PictureDesc {
  Backend backend = Backend::Cpu;  // of the rasteriser; Reference also selects the reference tracer
  bool layers = false;
  int samples = 0;      // GGX rays per rough pixel; 0 = the lobe used in training
  bool medium = false;  // true: through the water or haze of the photos, as they show the scene
};

class ScenePainter {
 public:
  ScenePainter(TrainedScene scene, const PictureDesc& desc);
  // At the size of the view's intrinsics.
  ViewPicture picture(const View& view);
  const SplatScene& surfels() const { return scene_.surfels; }
  SplatScene& surfels() { return scene_.surfels; }                                // the next picture shows changed values
  const ImageOptions& picture_options() const { return model_.options(); }  // with those of PictureDesc
  const Frame& frame() const { return frame_; }                             // of the last picture
  const ImageOptions& image() const { return scene_.image; }

 private:
  TrainedScene scene_;
  PictureDesc desc_;
  LayeredModel model_;
  Frame frame_;
};

}  // namespace vitrine
