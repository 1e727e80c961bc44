// The options of the image formation, one struct per pass. A trainer changes them between steps through ImageModel::options()
// (the phases of a run are nothing else); an evaluation sets samples and layer images and lifts the budget.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/render/model/kernels/layer_blend.h"
#include "core/render/raster/renderer.h"
#include "core/scene/shape/shape_set.h"
#include "core/render/trace/tracer.h"

namespace vitrine {

class ThickGlass;

struct DiffuseOptions {
  Backend backend = Backend::Cpu;
  int sh_degree = 1;        // used for colour; at most the layer's
  bool distortion = false;  // compute the distortion channel
  float near_z = 0.01f;     // scene units; surfels nearer to the camera's plane are not seen
  bool materials = false;   // blend f0, roughness, k_s, tau even while there is no other layer (a loss looks at them)
};

// Known shapes: surfaces that specular pixels show (ShapePass, roles Mirror and Coat), and panes that are flat mirrors (PanePass,
// role Sheet). nullptr: none is known.
struct ShapeOptions {
  std::shared_ptr<const ShapeSet> set = nullptr;
  float min_alpha = 0.5f;   // no surface below
  float polished = 0.3f;    // k_s of what is
  bool silhouettes = true;  // pixels at their silhouettes, too (SilhouettePass)
};

// Which pixels send rays, and what comes back along them to the diffuse layer.
struct SurfaceOptions {
  int ray_budget = 0;             // pixels that send rays in one picture; 0 = all that ask
  float min_alpha = 0.5f;         // no surface below
  float mask_threshold = 0.5f;    // pixels whose mask exceeds it ask for rays whatever their weights
  bool normal_gradient = true;    // rays turn normals
  bool depth_gradient = true;     // rays move surfaces; better off for the first steps with a reflection layer
  float normal_quantile = 0.99f;  // longer gradients of normals are shortened to this quantile of the picture; 1 = off
};

enum class Lobe : unsigned char {
  Mirror,   // one ray, roughness ignored
  Sampled,  // GGX half vectors: unbiased, noisy; `samples` rays where the surface is rough
};

struct ReflectionOptions {
  TracerBackend backend = TracerBackend::Embree;
  int sh_degree = 1;
  Lobe lobe = Lobe::Mirror;
  int samples = 1;             // of a rough pixel with Lobe::Sampled: one in training, many at evaluation
  float mirror_below = 0.05f;  // Lobe::Sampled: smoother surfaces send one mirror ray (their lobe is a few pixels wide)
  float near = 0.01f;          // scene units; nothing nearer to the surface is seen in it
  float min_transmittance = 1e-3f;
};

// How what is behind glass comes to the pixel.
enum class Glass : unsigned char {
  Traced,  // rays through the transmittance layer, from just behind the surface (TransmissionPass)
  Thin,    // straight on: the opaque surfels of the diffuse layer and the transmittance layer, rasterised (ThinGlassPass)
};

struct TransmissionOptions {
  Glass glass = Glass::Traced;
  TracerBackend backend = TracerBackend::Embree;
  int sh_degree = 1;
  float near = 0.01f;  // scene units behind the surface
  float min_transmittance = 1e-3f;
  // Glass::Thin: shells that are solid all the same; what they show comes along bent rays (bent_rays.h). nullptr: none.
  std::shared_ptr<const ThickGlass> thick = nullptr;
};

struct PaneOptions {
  // So many surfels of the diffuse layer are mirrored, its first ones. What follows are guesses about what no photo shows; panes
  // that photos do show know better, through the reflection layer.
  size_t mirrored = SIZE_MAX;
};

struct CompositeOptions {
  LayerBlend blend = LayerBlend::Layered;
  // Gradient gate: where the reflected part of the picture varies strongly among neighbours, less gradient reaches the
  // transmitted radiance: exp(-gate * Var_3x3 sqrt(w_r C_r)) (Shi et al. 2026, "RT-Splatting"). 0 = off.
  float gate = 4.f;
  bool layer_images = false;  // fill Frame::layers
};

// Pictures of a scene that has an opaque twin (OpaquePass).
struct OpaqueOptions {
  float layered = 1;  // share of the layers where no known shape is shown
};

struct ImageOptions {
  DiffuseOptions diffuse = {};
  ShapeOptions shape = {};
  SurfaceOptions surface = {};
  ReflectionOptions reflection = {};
  TransmissionOptions transmission = {};
  PaneOptions panes = {};
  CompositeOptions composite = {};
  OpaqueOptions opaque = {};
};

}  // namespace vitrine
