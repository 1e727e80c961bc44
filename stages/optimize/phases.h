// Which layer is trained when (algorithms 5.9). All times are parts of the run, so that presets of any length share them:
//   diffuse        from the start; alone until reflection or transmittance begin
//   reflection     its surfels, and the specular weight, f0 and (later) the roughness of the diffuse layer
//   transmittance  its surfels, and the transmission of the diffuse layer
//   joint          the last part: all layers together, at low rates
// While a later phase runs, the geometry of the diffuse layer moves at a factor of its rates.
#pragma once

#include <algorithm>
#include <string>

#include "core/foundation/config/describe.h"
#include "core/render/model/image_options.h"
#include "core/learn/optim/rates.h"
#include "core/learn/trainer/shape_training.h"

namespace vitrine {

// Layers that a run has.
struct LayerChoice {
  bool reflection = false, transmittance = false;
  bool any() const { return reflection || transmittance; }
  bool has(LayerKind kind) const {
    return kind == LayerKind::Diffuse || (kind == LayerKind::Reflection ? reflection : transmittance);
  }
};
enum class WantedLayers { Auto, Diffuse, Reflection, Full };
// Auto: what masks of glass and of mirrors need; objects that are only guessed do not count (ObjectSet::trusted).
LayerChoice chosen_layers(WantedLayers wanted, bool has_specular_mask, bool has_transparent_mask);

// Values that EXPERIMENTS.md measured; tests shorten them, users do not set them.
struct LayerPhase {
  double from = 0.3, ramp = 0.05;  // start; time over which the rates rise from zero
  double densify_until = 0.75;     // end of relocation and growth
  double share = 0.2;              // of max_gaussians
  int initial_surfels = 6000;      // at most
  int hull_points = 4000;          // diffuse surfels on the shapes of this phase's objects
  int sh_degree = 2;               // view dependence of its colour
};

struct ReflectionPhase : LayerPhase {
  double specular_weight = 0.3, f0 = 0.3;  // inside the specular mask, to start from
  // Where the shape of what reflects is known: it begins as a mirror, and keeps its shape as far as it is one.
  double known_specular_weight = 0.9, known_f0 = 0.8, known_factor = 0.02;
  double coat_specular_weight = 0.03, coat_f0 = 0.04;  // of paint under a coat, to start from; Fresnel acts whatever k_s
  int known_hull_points = 3000;  // in place of hull_points: opaque surfels, which only help where they stand right
  double roughness_from = 0.4;
  double surface_from = 0.36;      // rays turn and move surfaces
  double silhouettes_from = 0.36;  // known shapes decide how much of the pixels at their silhouettes they cover
  double shape_rate = 1e-4;        // of a known shape's lengths, scene units
  double axis_rate = 4e-4;         // of its angles, radians
};
struct TransmittancePhase : LayerPhase {
  double transmission = 0.98, specular_weight = 0.002, f0 = 0.077;  // of glass, to start from
  double glass_factor = 0.05;                                       // on top, where the diffuse layer is transparent
  bool one_glass = true;                                            // all glass has the same f0 and k_s
};
struct DiffusePhase {
  double specular_weight = 0.3;  // of the picture losses on gloss (specular, not transparent), until reflection begins
};
// How the layers become a picture (core/render/model).
struct ShadingConfig {
  LayerBlend blend = LayerBlend::Layered;
  Lobe lobe = Lobe::Mirror;
  Glass glass = Glass::Thin;
  int ray_budget = 0;
  // Tests switch these off. Thin glass of known shape is rendered from its shape and reflects the scene at both walls of each
  // sheet; known mirrors have the surface of their shape, which learns from what it reflects.
  bool panes = true, shapes = true;
};
void describe(Describer& d, ShadingConfig& c);

struct JointPhase {
  double from = 0.9;
  double rate_factor = 0.2;
};

struct PhasesConfig {
  DiffusePhase diffuse;
  ReflectionPhase reflection;
  TransmittancePhase transmittance;
  JointPhase joint;
  PhasesConfig();

  const LayerPhase& of(LayerKind kind) const {
    return kind == LayerKind::Reflection ? static_cast<const LayerPhase&>(reflection) : transmittance;
  }
  // That the beginning of a layer may place: shapes are known when it begins.
  int most_hull_points(LayerKind kind) const {
    const int points = of(kind).hull_points;
    return kind == LayerKind::Reflection && points > 0 ? std::max(points, reflection.known_hull_points) : points;
  }
};

// What the phases say at one moment of the run.
class PhaseClock {
 public:
  PhaseClock(const PhasesConfig& config, const LayerChoice& layers, double fraction)
      : config_(config), layers_(layers), fraction_(fraction) {}

  bool begun(LayerKind kind) const {
    return kind == LayerKind::Diffuse || (layers_.has(kind) && fraction_ >= config_.of(kind).from);
  }
  // The passes' options at this moment, for training; `sh_degree`: of the diffuse layer.
  ImageOptions image_options(const ShadingConfig& shading, Backend backend, int sh_degree) const;
  // Step sizes of a layer: of `rates` zero for what no phase trains yet.
  AttributeRates rates(LayerKind kind, const RatesConfig& rates, double scene_radius) const;
  ShapeRates shape_rates() const;

 private:
  double ramp(const LayerPhase& phase) const;
  AttributeRates diffuse_rates(const RatesConfig& rates, double scene_radius) const;
  const PhasesConfig& config_;
  LayerChoice layers_;
  double fraction_;
};

}  // namespace vitrine
