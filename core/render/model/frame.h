// All images and rays of one rendered view: raster channels, secondary rays, linear and display-referred picture, and the
// gradient of each. Passes read and write frames; images are planar [c, h, w].
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/render/model/image_options.h"
#include "core/render/model/secondary_rays.h"
#include "core/render/model/silhouette_pixels.h"
#include "core/render/model/thick_glass.h"
#include "core/render/raster/raster_desc.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

// The picture split into layers (CompositeOptions::layer_images), linear, before the view's gain. The first three sum to
// Frame::linear, in a medium to Frame::clear. Pixels without rays of a kind are zero (inner_transmittance: one).
struct LayerImages {
  std::vector<float> diffuse, reflection, transmission;  // [3,h,w] w_d C_d and the opaque twin, w_r C_r, w_t C_t
  std::vector<float> reflected, transmitted;             // [3,h,w] C_r, C_t as traced
  std::vector<float> fresnel;                            // [3,h,w] F
  std::vector<float> inner_transmittance;                // transmittance of the transmittance layer
  void clear();
};

// Radiance behind thin glass (ThinGlassPass), for every pixel that requests transmission, whether or not it sends rays;
// elsewhere black with transmittance 1. Empty if unused.
struct BehindGlass {
  std::vector<float> radiance, grad_radiance;  // [3,h,w]
  std::vector<float> inner_transmittance;      // behind the last surfel
  std::vector<GlassPath> path;                 // where some glass is thick; otherwise empty
  std::vector<float> median_z;                 // depth at transmittance 1/2, if reached
  std::vector<float> picture_weight;           // weight of the radiance in the picture: mean over the channels (CompositePass)
  void clear();                                // keeps picture_weight
};

// Known thin and solid glass in front of the surfels (SheetPass). Empty if the picture has none.
struct SheetImages {
  std::vector<uint32_t> entry;                     // [h,w] 1 + the first glass entry along the pixel's ray, 0: none
  std::vector<uint32_t> element;                   // [h,w] element of the entry (ShapeHit)
  std::vector<float> coverage;                     // [h,w] of the pixel
  std::vector<uint8_t> solid;                      // [h,w] 1: that entry is solid glass
  std::vector<float> behind_alpha, behind_median;  // [h,w] the channels Alpha and MedianZ of the surfels alone
  bool empty() const { return entry.empty(); }
  bool shows(uint32_t pixel) const { return !entry.empty() && entry[pixel] != 0; }
  bool shows_solid(uint32_t pixel) const { return !solid.empty() && solid[pixel] != 0; }
  void clear();
};

// Reflections of the two panes of a glass case through which a pixel's ray enters and leaves (PanePass). Empty if the picture
// has no case.
struct PaneImages {
  std::vector<uint8_t> shown;                // [h,w] the pixel shows the case
  std::vector<float> near_color, far_color;  // [3,h,w] reflected radiance of the scene
  std::vector<float> near_open, far_open;    // [h,w] transmittance of that reflection
  std::vector<float> far_share, far_cosine;  // [h,w] 1: the ray leaves through the far pane; cosine there
  // Flat mirrors, whose gradients train the mirrored scene; empty without one.
  std::vector<uint8_t> passes_gradient;             // [h,w]
  std::vector<float> grad_near, grad_open;  // [3,h,w], [h,w] dL/dnear_color, dL/dnear_open
  std::vector<float> picture_weight;        // [h,w] of near_color in the pixel
  bool empty() const { return shown.empty(); }
  void clear();
  void start(size_t pixels);
};

// Pixels at the silhouettes of known shapes (SilhouettePass) and the two pictures blended there. Empty if unused.
struct SilhouetteImages {
  std::vector<uint32_t> shapes;               // [h,w] 1 + the entry shown by a specular pixel (ShapePass), 0: none
  std::vector<SilhouettePixel> pixels;        // ascending
  std::vector<float> rest, grad_rest, solid;  // [pixel][3] linear radiance: behind the shape, and of the shape in crossed
                                              // pixels
  std::vector<float> grad_covered;            // [pixel]
  void clear();                               // keeps shapes
};

// Pixels that show a coated shape (ShapePass): the raster channels remain those of the paint, reflections use the surface of
// the shape. Empty if unused.
struct CoatImages {
  std::vector<uint32_t> entry;   // [h,w] 1 + the entry shown, 0: none
  std::vector<float> normal, z;  // [3,h,w] unit, [h,w] z-depth of the shape; z 0: use those of the surfels
  bool shows(uint32_t pixel) const { return !entry.empty() && entry[pixel] != 0; }
  bool of_shape(uint32_t pixel) const { return shows(pixel) && z[pixel] > 0; }
  void clear();
  void start(size_t pixels);
};

// The scene without glass as one layer (ThinGlassPass): the opaque surfels of the diffuse layer, then the transmittance layer.
struct OpenedScene {
  SplatLayer surfels;
  std::vector<uint32_t> opaque;                        // indices in the diffuse layer, ascending
  void clear() { surfels.resize(0), opaque.clear(); }  // keeps the memory
};

struct Frame {
  const View* view = nullptr;  // pose, gains, and intrinsics at the size of the picture
  ImageOptions options;        // of the model, for this picture

  // Set by the caller before forward(). Masks are [h,w] in [0,1] or empty; pixels inside request rays.
  std::span<const float> specular_mask, transparent_mask;
  uint64_t seed = 0, step = 0;  // of all random numbers: equal values give equal rays
  bool differentiable = true;   // false: render only, without backward(), with less memory

  RasterImages diffuse;                    // channels of the diffuse pass
  ShadedPixels shaded;                     // pixels that send rays
  SecondaryRays reflection, transmission;  // their rays through the two other layers
  SheetImages sheets;
  PaneImages panes;
  SilhouetteImages silhouette;
  CoatImages coats;
  OpenedScene opened;
  BehindGlass behind;
  std::vector<float> linear;  // [3,h,w] radiance towards the camera, before the view's gain
  std::vector<float> clear;   // [3,h,w] Frame::linear without the medium (MediumPass); empty without one
  std::vector<float> srgb;    // [3,h,w] predicted photo
  LayerImages layers;

  RasterImages grad_diffuse;
  std::vector<float> grad_linear, grad_srgb;
  std::vector<float> error_image;  // [h,w] or empty: per-pixel error, distributed to the surfels (densification)
  SurfelStatistics statistics;     // of the diffuse layer: sums over the backward of all passes that render its surfels

  size_t pixel_count() const { return view->intrinsics.pixel_count(); }
};

}  // namespace vitrine
