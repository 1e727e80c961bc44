// Options of the image formation, one struct per pass. Trainers change them between steps through ImageModel::options() to
// implement training phases; evaluation sets samples and layer images and removes the ray budget.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/render/model/kernels/layer_blend.h"
#include "core/render/model/kernels/medium.h"
#include "core/render/raster/renderer.h"
#include "core/scene/shape/shape_set.h"
#include "core/render/trace/tracer.h"

namespace vitrine {

class ThickGlass;

struct DiffuseOptions {
  Backend backend = Backend::Cpu;
  int sh_degree = 1;        // used for colour; at most the layer's
  bool distortion = false;  // compute the distortion channel
  float near_z = 0.01f;     // scene units; near clipping plane
  bool materials = false;   // blend f0, roughness, k_s, tau even without another layer (a loss reads them)
};

// Known shapes: surfaces of specular pixels (ShapePass, roles Mirror and Coat), and flat mirrors and panes (PanePass, role
// Sheet). nullptr: none.
struct ShapeOptions {
  std::shared_ptr<const ShapeSet> set = nullptr;
  float min_alpha = 0.5f;   // no surface below this alpha
  float min_specular = 0.3f;    // minimum k_s of a mirror
  bool silhouettes = true;  // treat pixels at silhouettes (SilhouettePass)
};

// Selection of pixels that send rays, and the gradients that return along the rays to the diffuse layer.
struct SurfaceOptions {
  int ray_budget = 0;             // maximum number of pixels that send rays per picture; 0 = all that request rays
  float min_alpha = 0.5f;         // no surface below this alpha
  float mask_threshold = 0.5f;    // pixels whose mask exceeds it request rays regardless of their weights
  bool normal_gradient = true;    // propagate ray gradients to normals
  bool depth_gradient = true;     // propagate ray gradients to depths; better off for the first steps with a reflection layer
  float normal_quantile = 0.99f;  // gradients of normals are clamped to this quantile of the picture; 1 = off
};

enum class Lobe : unsigned char {
  Mirror,   // one ray, roughness ignored
  Sampled,  // GGX half vectors: unbiased, noisy; `samples` rays where the surface is rough
};

struct ReflectionOptions {
  TracerBackend backend = TracerBackend::Embree;
  int sh_degree = 1;
  Lobe lobe = Lobe::Mirror;
  int samples = 1;             // of a rough pixel with Lobe::Sampled: one in training, many in evaluation
  float mirror_below = 0.05f;  // Lobe::Sampled: smoother surfaces send one mirror ray (their lobe is a few pixels wide)
  float near = 0.01f;          // scene units; start of the ray from the surface
  float min_transmittance = 1e-3f;
};

// Rendering of the scene behind glass.
enum class Glass : unsigned char {
  Traced,  // rays through the transmittance layer, starting just behind the surface (TransmissionPass)
  Thin,    // unrefracted: rasterises the opaque surfels of the diffuse layer and the transmittance layer (ThinGlassPass)
};

struct TransmissionOptions {
  Glass glass = Glass::Traced;
  TracerBackend backend = TracerBackend::Embree;
  int sh_degree = 1;
  float near = 0.01f;  // scene units behind the surface
  float min_transmittance = 1e-3f;
  // Glass::Thin: closed glass meshes that are solid; refracted rays render them (bent_rays.h). nullptr: none.
  std::shared_ptr<const ThickGlass> thick = nullptr;
};

struct PaneOptions {
  // Number of diffuse surfels that are mirrored, from the first one. The following surfels are guesses about unobserved
  // regions; panes seen in photos get better reflections from the reflection layer.
  size_t mirrored = SIZE_MAX;
};

struct CompositeOptions {
  LayerBlend blend = LayerBlend::Layered;
  // Gradient gate: high local variance of the reflected radiance reduces the gradient of the transmitted radiance: exp(-gate *
  // Var_3x3 sqrt(w_r C_r)) (Shi et al. 2026, "RT-Splatting"). 0 = off.
  float gate = 4.f;
  bool layer_images = false;  // fill Frame::layers
};

// Scenes with an opaque twin (OpaquePass).
struct OpaqueOptions {
  float layered = 1;  // blend weight of the layered picture where no known shape is visible
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
  std::optional<MediumCoefficients<double>> medium = {};  // water or haze (MediumPass)
};

}  // namespace vitrine
