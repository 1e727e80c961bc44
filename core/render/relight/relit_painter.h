// Renders a scene under another light (README). The surface of each pixel is rasterised from the surfels and shaded with the
// materials of the decompose stage; rays for shadows, reflections and one bounce are traced through the mesh.
//
//   RelitPainter painter(scene);
//   painter.set_lighting(lighting);                     // computes the light on the mesh and behind glass, once
//   RelitPicture p = painter.picture(view, {.samples = 64});
//
// Same scene, lighting, view and desc give the same bytes for any number of threads.
#pragma once

#include <functional>
#include <memory>

#include "core/render/model/layered_model.h"
#include "core/render/relight/glass_content.h"
#include "core/render/relight/lit_place.h"
#include "core/render/relight/lit_scene.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct RelitPictureDesc {
  int samples = 64;  // per pixel; each traces one ray to the light and one into the material's lobe
  uint64_t seed = 1;
  std::function<void(double)> progress = {};  // fraction done; called from one thread
};

struct RelitPicture {
  ImageF radiance;  // [h, w, 3] linear, in the units of the lighting; the environment where there is no surface
  ImageF albedo;    // [h, w, 3] of the surface, times coverage
  ImageF coverage;  // [h, w, 1] of the surfels
};

class RelitPainter {
 public:
  explicit RelitPainter(RelitScene scene);
  RelitPainter(const RelitPainter&) = delete;
  RelitPainter& operator=(const RelitPainter&) = delete;

  // Takes seconds to a minute; throws (core/foundation/base/process.h) when the program must stop.
  void set_lighting(Lighting lighting, const LitSceneDesc& desc = {});
  // The lighting of another painter, whose scene contains this one: its surfaces throw shadows and light on what this one shows.
  // The other must outlive this one.
  void share_lighting(const RelitPainter& other, const LitSceneDesc& desc = {});
  // At the size of the view's intrinsics; its gain is ignored.
  RelitPicture picture(const View& view, const RelitPictureDesc& desc = {});

  const RelitScene& scene() const { return scene_; }
  const LitScene& lit() const { return *lit_; }

 private:
  std::optional<SurfacePlace> place_on_mesh(const LitPlace& at, const SceneSurface& surface) const;
  Vec3f from_below(ShownSurface& shown, const LitPlace& at, const SurfacePlace& place, const Vec3f& eye) const;

  RelitScene scene_;
  SceneSurface surface_;
  GlassContent glass_;
  SplatScene shown_;  // diffuse surfels with albedo and materials
  LayeredModel model_;
  Frame frame_;
  Lighting lighting_;
  std::shared_ptr<const LitScene> lit_;
};

// Stops that map the mean radiance of the mesh to middle grey, rounded to a tenth. Equal for all pictures of a lighting.
double exposure_of_scene(const LitScene& lit);

// Converts linear radiance [h, w, 3] to sRGB, brightened by `stops`.
Image8 developed(const ImageF& radiance, double stops);

}  // namespace vitrine
