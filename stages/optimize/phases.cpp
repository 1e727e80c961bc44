#include "stages/optimize/phases.h"

#include <algorithm>

namespace vitrine {

void describe(Describer& d, ShadingConfig& c) {
  d.choice("blend", c.blend, {"rtrgs", "layered"},
           "How diffuse, reflected and transmitted light add up: layered (GLINT) or rtrgs (core/render/model/README.md).");
  d.choice("lobe", c.lobe, {"mirror", "sampled"},
           "Rays of rough surfaces: mirror ignores roughness, sampled draws one GGX direction a ray.");
  d.choice("glass", c.glass, {"traced", "thin"},
           "What is seen through glass: thin rasterises the scene behind it, the transmittance layer included; traced "
           "sends rays through the transmittance layer alone.");
  d.option("ray_budget", c.ray_budget, "Pixels of a picture that send rays in a training step; 0 = all that reflect or transmit.")
      .range(0, 100000000);
}

PhasesConfig::PhasesConfig() {
  reflection.share = 0.1;
  reflection.hull_points = 1000;
  transmittance.from = 0.15;
  transmittance.share = 0.15;
  transmittance.initial_surfels = 100000;
}

LayerChoice chosen_layers(WantedLayers wanted, bool has_specular_mask, bool has_transparent_mask) {
  if (wanted == WantedLayers::Diffuse) return {};
  if (wanted == WantedLayers::Reflection) return {.reflection = true, .transmittance = false};
  if (wanted == WantedLayers::Full) return {.reflection = true, .transmittance = true};
  return {.reflection = has_specular_mask || has_transparent_mask, .transmittance = has_transparent_mask};
}

ImageOptions PhaseClock::image_options(const ShadingConfig& shading, Backend backend, int sh_degree) const {
  const ReflectionPhase& reflection = config_.reflection;
  const TracerBackend tracer = backend == Backend::Reference ? TracerBackend::Reference : TracerBackend::Embree;
  ImageOptions o;
  o.diffuse = {.backend = backend, .sh_degree = sh_degree};
  o.surface.ray_budget = shading.ray_budget;
  o.surface.normal_gradient = o.surface.depth_gradient = fraction_ >= reflection.surface_from;
  o.shape.silhouettes = fraction_ >= reflection.silhouettes_from;
  o.reflection.backend = o.transmission.backend = tracer;
  o.reflection.sh_degree = reflection.sh_degree;
  o.reflection.lobe = fraction_ >= reflection.roughness_from ? shading.lobe : Lobe::Mirror;
  o.transmission.glass = shading.glass;
  o.transmission.sh_degree = config_.transmittance.sh_degree;
  o.composite.blend = shading.blend;
  return o;
}

double PhaseClock::ramp(const LayerPhase& phase) const {
  return phase.ramp > 0 ? std::clamp((fraction_ - phase.from) / phase.ramp, 0.0, 1.0) : 1;
}

AttributeRates PhaseClock::diffuse_rates(const RatesConfig& rates, double scene_radius) const {
  AttributeRates r = rates_at(rates, fraction_, scene_radius);
  const auto scale = [&](Attribute a, double factor) { r[static_cast<size_t>(a)] *= static_cast<float>(factor); };
  const bool reflection = begun(LayerKind::Reflection), transmittance = begun(LayerKind::Transmittance);
  for (Attribute a : {Attribute::F0, Attribute::SpecularWeight}) scale(a, reflection ? ramp(config_.reflection) : 0);
  scale(Attribute::Roughness, reflection && fraction_ >= config_.reflection.roughness_from ? ramp(config_.reflection) : 0);
  scale(Attribute::Transmission, transmittance ? ramp(config_.transmittance) : 0);
  return r;
}

ShapeRates PhaseClock::shape_rates() const {
  const double factor = fraction_ >= config_.joint.from ? config_.joint.rate_factor : 1;
  const ReflectionPhase& c = config_.reflection;
  return {.length = factor * c.shape_rate, .angle = factor * c.axis_rate};
}

AttributeRates PhaseClock::rates(LayerKind kind, const RatesConfig& rates, double scene_radius) const {
  AttributeRates r{};
  if (kind == LayerKind::Diffuse) {
    r = diffuse_rates(rates, scene_radius);
  } else if (begun(kind)) {
    const LayerPhase& phase = config_.of(kind);
    r = rates_at(rates, fraction_, scene_radius);  // the surfels are copies of trained ones: no warm-up
    for (float& rate : r) rate *= static_cast<float>(ramp(phase));
  }
  if (layers_.any() && fraction_ >= config_.joint.from)
    for (float& rate : r) rate *= static_cast<float>(config_.joint.rate_factor);
  return r;
}

}  // namespace vitrine
