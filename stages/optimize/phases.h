// Schedule of the training phases per layer (algorithms 5.9). All times are fractions of the run, valid for presets of any
// length:
//   diffuse        from the start; alone until reflection or transmittance begin
//   reflection     its surfels, and the specular weight, f0 and (later) the roughness of the diffuse layer
//   transmittance  its surfels, and the transmission of the diffuse layer
//   joint          the last part: all layers together, at low rates
// While a later phase runs, the rates of the diffuse geometry are reduced by a factor.
#pragma once

#include <algorithm>
#include <string>

#include "core/foundation/config/describe.h"
#include "core/render/model/image_options.h"
#include "core/learn/optim/rates.h"
#include "core/learn/trainer/shape_training.h"

namespace vitrine {

// Layers that a run trains.
struct LayerChoice {
  bool reflection = false, transmittance = false;
  bool any() const { return reflection || transmittance; }
  bool has(LayerKind kind) const {
    return kind == LayerKind::Diffuse || (kind == LayerKind::Reflection ? reflection : transmittance);
  }
};
enum class WantedLayers { Auto, Diffuse, Reflection, Full };
// Auto: the layers that glass and mirror masks require; guessed objects do not count (ObjectSet::trusted).
LayerChoice chosen_layers(WantedLayers wanted, bool has_specular_mask, bool has_transparent_mask);

// Values measured in EXPERIMENTS.md; tests shorten them, users do not set them.
struct LayerPhase {
  double from = 0.3, ramp = 0.05;  // start; time in which the rates rise from zero
  double densify_until = 0.75;     // end of relocation and growth
  double share = 0.2;              // of max_gaussians
  int initial_surfels = 6000;      // upper bound
  int hull_points = 4000;          // diffuse surfels on the shapes of this phase's objects
  int sh_degree = 2;               // of the layer's colour
};

struct ReflectionPhase : LayerPhase {
  double specular_weight = 0.3, f0 = 0.3;  // initial values inside the specular mask
  // For mirrors of known shape: they start as mirrors, and keep their shape while they are mirrors.
  double known_specular_weight = 0.9, known_f0 = 0.8, known_factor = 0.02;
  double coat_specular_weight = 0.03, coat_f0 = 0.04;  // initial values of a coat's diffuse surfels; Fresnel acts for any k_s
  int known_hull_points = 3000;                        // replaces hull_points: opaque surfels, which help only at exact positions
  double roughness_from = 0.4;
  double surface_from = 0.36;      // rays optimise the orientation and position of surfaces
  double silhouettes_from = 0.36;  // known shapes determine the coverage of silhouette pixels
  double shape_rate = 1e-4;        // of the lengths of a known shape, scene units
  double axis_rate = 4e-4;         // of the angles of a known shape, radians
};
struct TransmittancePhase : LayerPhase {
  double transmission = 0.98, specular_weight = 0.002, f0 = 0.077;  // initial values of glass
  double glass_factor = 0.05;                                       // additional factor where the diffuse layer is transparent
  bool one_glass = true;                                            // all glass shares f0 and k_s
};
struct DiffusePhase {
  double specular_weight = 0.3;  // of the picture losses on mirror pixels (specular, not transparent), until reflection begins
};
// Composition of the layers into a picture (core/render/model).
struct ShadingConfig {
  LayerBlend blend = LayerBlend::Layered;
  Lobe lobe = Lobe::Mirror;
  Glass glass = Glass::Thin;
  int ray_budget = 0;
  // Tests disable these. panes: thin glass of known shape is rendered from its shape and reflects the scene at both of its walls.
  // shapes: known mirrors use the surface of their shape, which is optimised from the reflections.
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
  // Largest number of surfels that the beginning of a layer places; the shapes are known only then.
  int most_hull_points(LayerKind kind) const {
    const int points = of(kind).hull_points;
    return kind == LayerKind::Reflection && points > 0 ? std::max(points, reflection.known_hull_points) : points;
  }
};

// Phase parameters at one moment of the run.
class PhaseClock {
 public:
  PhaseClock(const PhasesConfig& config, const LayerChoice& layers, double fraction)
      : config_(config), layers_(layers), fraction_(fraction) {}

  bool begun(LayerKind kind) const {
    return kind == LayerKind::Diffuse || (layers_.has(kind) && fraction_ >= config_.of(kind).from);
  }
  // Image options for training at this moment; `sh_degree`: of the diffuse layer.
  ImageOptions image_options(const ShadingConfig& shading, Backend backend, int sh_degree) const;
  // Learning rates of a layer; zero for attributes that no phase trains yet.
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
