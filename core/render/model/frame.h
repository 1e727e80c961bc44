// Everything that is known about one picture of one view while it is formed: the raster channels, the rays that left its
// surfaces, the linear and the display-referred picture, and beside each its gradient. Passes read and write frames; planar
// images [c, h, w].
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

// The picture taken apart (CompositeOptions::layer_images), linear, before the view's gain. The first three add up to
// Frame::linear. Where a pixel sends no ray of a kind: zero (inner_transmittance: one).
struct LayerImages {
  std::vector<float> diffuse, reflection, transmission;  // [3,h,w] w_d C_d and the opaque twin, w_r C_r, w_t C_t
  std::vector<float> reflected, transmitted;             // [3,h,w] C_r, C_t as traced
  std::vector<float> fresnel;                            // [3,h,w] F
  std::vector<float> inner_transmittance;                // [h,w] what the transmittance layer lets through to whatever is behind
  void clear();
};

// What thin glass shows of what stands behind it (ThinGlassPass): of every pixel that asks for it, whichever send rays; black,
// with nothing in the way, elsewhere. Empty without.
struct BehindGlass {
  std::vector<float> radiance, grad_radiance;  // [3,h,w]
  std::vector<float> inner_transmittance;      // [h,w] past the last surfel
  std::vector<GlassPath> path;                 // [h,w] where some glass is thick; empty without
  std::vector<float> median_z;                 // [h,w] where half of it is passed, if so much stands there at all
  std::vector<float> picture_weight;  // [h,w] what the radiance counts in the picture: mean over the channels (CompositePass)
  void clear();                       // but for picture_weight
};

// Known sheets and blocks of glass that stand before what the surfels show (SheetPass). Empty without one in the picture.
struct SheetImages {
  std::vector<uint32_t> entry;                     // [h,w] 1 + the entry that the pixel looks through first, 0: none
  std::vector<uint32_t> element;                   // [h,w] which part of it (ShapeHit)
  std::vector<float> coverage;                     // [h,w] of the pixel
  std::vector<uint8_t> solid;                      // [h,w] 1: that entry is solid glass
  std::vector<float> behind_alpha, behind_median;  // [h,w] the channels Alpha and MedianZ of the surfels alone
  bool empty() const { return entry.empty(); }
  bool shows(uint32_t pixel) const { return !entry.empty() && entry[pixel] != 0; }
  bool shows_solid(uint32_t pixel) const { return !solid.empty() && solid[pixel] != 0; }
  void clear();
};

// What the two panes of a case mirror by which a pixel's ray enters and leaves it (PanePass). Empty without a case in the
// picture.
struct PaneImages {
  std::vector<uint8_t> shown;                // [h,w] the pixel looks at the case
  std::vector<float> near_color, far_color;  // [3,h,w] of the scene
  std::vector<float> near_open, far_open;    // [h,w] how far it shows nothing of the scene
  std::vector<float> far_share, far_cosine;  // [h,w] whether the pixel looks out through it; cosine of the ray with its normal
  // Of flat mirrors, which teach what they show; empty without one.
  std::vector<uint8_t> teaches;             // [h,w]
  std::vector<float> grad_near, grad_open;  // [3,h,w], [h,w] dL/dnear_color, dL/dnear_open
  std::vector<float> picture_weight;        // [h,w] of near_color in the pixel
  bool empty() const { return shown.empty(); }
  void clear();
  void start(size_t pixels);
};

// Pixels at the silhouettes of known shapes (SilhouettePass), and the two pictures that they show side by side. Empty without.
struct SilhouetteImages {
  std::vector<uint32_t> shapes;               // [h,w] 1 + the entry that a specular pixel shows (ShapePass), 0: none
  std::vector<SilhouettePixel> pixels;        // ascending
  std::vector<float> rest, grad_rest, solid;  // [pixel][3] linear radiance: behind the silhouette, of the shape where it crosses
  std::vector<float> grad_covered;            // [pixel]
  void clear();                               // but for shapes
};

// Pixels that show a coat (ShapePass): the channels stay those of the paint, reflections take the surface of the shape. Empty
// without.
struct CoatImages {
  std::vector<uint32_t> entry;   // [h,w] 1 + the entry that is shown, 0: none
  std::vector<float> normal, z;  // [3,h,w] unit, [h,w] z-depth, where the shape tells them; z 0: the surfels do
  bool shows(uint32_t pixel) const { return !entry.empty() && entry[pixel] != 0; }
  bool of_shape(uint32_t pixel) const { return shows(pixel) && z[pixel] > 0; }
  void clear();
  void start(size_t pixels);
};

// Everything but the glass in one layer (ThinGlassPass): the opaque surfels of the diffuse layer, then the transmittance layer.
struct OpenedScene {
  SplatLayer surfels;
  std::vector<uint32_t> opaque;                        // which of the diffuse layer, ascending
  void clear() { surfels.resize(0), opaque.clear(); }  // memory stays
};

struct Frame {
  const View* view = nullptr;  // pose, gains, and intrinsics at the size of the picture
  ImageOptions options;        // of the model, when it formed the picture

  // Set by the caller before forward(). Masks are [h,w] in [0,1] or empty; pixels inside ask for rays.
  std::span<const float> specular_mask, transparent_mask;
  uint64_t seed = 0, step = 0;  // of everything that is drawn: equal numbers, equal rays
  bool differentiable = true;   // false: only the picture is wanted; no backward() may follow, and memory stays small

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
  std::vector<float> srgb;    // [3,h,w] what the photo should show
  LayerImages layers;

  RasterImages grad_diffuse;
  std::vector<float> grad_linear, grad_srgb;
  std::vector<float> error_image;  // [h,w] or empty: what the surfels are to be blamed for (densification)
  SurfelStatistics statistics;     // of the diffuse layer: sums over all passes that show surfels of it, in reverse

  size_t pixel_count() const { return view->intrinsics.pixel_count(); }
};

}  // namespace vitrine
