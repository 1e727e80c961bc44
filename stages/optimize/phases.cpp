#include "stages/optimize/phases.h"

#include <algorithm>

namespace vitrine {

namespace {

void describe_layer(Describer& d, LayerPhase& c) {
  d.option("from", c.from, "Part of the run after which this layer takes part.").range(0, 1);
  d.option("until", c.until, "Part of the run after which this layer is no longer trained, only rendered.").range(0, 1);
  d.option("ramp", c.ramp, "Part of the run over which the rates of this phase rise from zero.").range(0, 1);
  d.option("densify_until", c.densify_until, "Part of the run after which its surfels are no longer moved or added.").range(0, 1);
  d.option("share", c.share, "Its part of max_gaussians.").range(0, 0.9);
  d.option("initial_surfels", c.initial_surfels, "Surfels that it starts from, at most.").range(1, 10000000);
  d.option("hull_points", c.hull_points,
           "Diffuse surfels that are placed on the hull of its masks (specular without transparent; transparent).")
      .range(0, 10000000);
  d.option("sh_degree", c.sh_degree, "View dependence of its colour: spherical harmonics up to this degree.").range(0, 3);
  d.option("geometry_factor", c.geometry_factor,
           "Factor on the diffuse layer's rates of position, rotation and scale from this phase on.")
      .range(0, 1);
}

}  // namespace

void describe(Describer& d, DiffusePhase& c) {
  d.option("specular_weight", c.specular_weight,
           "Weight of the picture losses inside the specular mask and outside the transparent one until the reflection layer "
           "begins, so that the diffuse layer does not bake reflections.")
      .range(0, 1);
}

void describe(Describer& d, ReflectionPhase& c) {
  describe_layer(d, c);
  d.option("specular_weight", c.specular_weight, "Specular weight inside the specular mask, to start from.").range(0.001, 0.999);
  d.option("f0", c.f0, "Reflectance at normal incidence inside the specular mask, to start from.").range(0.001, 0.999);
  d.option("roughness_from", c.roughness_from, "Part of the run after which the roughness is trained.").range(0, 1);
  d.option("known_specular_weight", c.known_specular_weight,
           "specular_weight where the shape of what reflects is known: a solid of revolution or a box, found in the masks.")
      .range(0.001, 0.999);
  d.option("known_hull_points", c.known_hull_points,
           "hull_points if the shape of something that reflects is known; with hull_points 0 none are placed either way.")
      .range(0, 10000000);
  d.option(
       "coat_specular_weight", c.coat_specular_weight,
       "specular_weight of paint under a clear coat (shapes of role coat), to start from; it reflects by Fresnel's law besides.")
      .range(0.001, 0.999);
  d.option("coat_f0", c.coat_f0, "f0 of a clear coat: it stays.").range(0.001, 0.999);
  d.option("known_f0", c.known_f0, "f0 where the shape of what reflects is known.").range(0.001, 0.999);
  d.option(
       "known_factor", c.known_factor,
       "Factor on the rates of the diffuse layer's geometry and opacity, as far as it is glossy, if the shape of something that "
       "reflects is known.")
      .range(0, 1);
  d.option("surface_from", c.surface_from, "Part of the run after which reflections turn and move the surfaces that show them.")
      .range(0, 1);
  d.option("silhouettes_from", c.silhouettes_from,
           "Part of the run after which known shapes tell the pixels at their silhouettes.")
      .range(0, 1);
  d.renamed("outlines_from", "silhouettes_from");
  d.option("shape_rate", c.shape_rate,
           "Step of the place and the profile of a known shape, scene units, from surface_from on; of appendages half of it.")
      .range(0, 0.1);
  d.option("axis_rate", c.axis_rate, "Step of the direction of its axis, radians.").range(0, 0.1);
  d.removed("beside_rate");
}

void describe(Describer& d, ShadingConfig& c) {
  d.option("blend", c.blend,
           "How diffuse, reflected and transmitted light add up: layered (GLINT) or rtrgs (core/model/README.md).")
      .choices({"layered", "rtrgs"});
  d.option(
       "lobe", c.lobe,
       "Rays of rough surfaces, from phases.reflection.roughness_from on: mirror ignores roughness, cone traces one wide ray, "
       "sampled one drawn ray.")
      .choices({"mirror", "cone", "sampled"});
  d.option("glass", c.glass,
           "What is seen through glass: thin shows the scene behind it straight on, the transmittance layer among it; traced "
           "sends rays through the transmittance layer alone.")
      .choices({"thin", "traced"});
  d.option(
      "panes", c.panes,
      "Thin glass of known shape is drawn from the shape and mirrors the scene in both walls that a ray passes; off: surfels show "
      "it, with one reflection, of the reflection layer.");
  d.option("shapes", c.shapes,
           "Polished things that are solids of revolution have the surface of the solid, which learns from what it mirrors; off: "
           "that of their surfels.");
  d.option("silhouettes", c.silhouettes,
           "Pixels at the silhouette of such a solid are told by it, too: how much of each it covers.");
  d.renamed("outlines", "silhouettes");
  d.option("ray_budget", c.ray_budget, "Pixels of a picture that send rays in a training step; 0 = all that reflect or transmit.")
      .range(0, 100000000);
  d.option("gate", c.gate, "Damps gradients of the transmitted layer where reflections vary strongly; 0 = off.").range(0, 1000);
  d.option("diffuse_in_transparent", c.diffuse_in_transparent,
           "Share of the gradient of the diffuse colour that is kept inside the transparent mask.")
      .range(0, 1);
}

void describe(Describer& d, TransmittancePhase& c) {
  describe_layer(d, c);
  d.option(
       "glass_factor", c.glass_factor,
       "Factor on the diffuse layer's rates of geometry and opacity where it is transparent: what is seen through it must not "
       "move it.")
      .range(0, 1);
  d.option("one_glass", c.one_glass,
           "All glass reflects alike: one f0 and one k_s for all of its surfels, which single photos would bend to their noise.");
}

void describe(Describer& d, JointPhase& c) {
  d.option("from", c.from, "Part of the run after which all layers are trained at low rates, when there is more than one.")
      .range(0, 1);
  d.option("rate_factor", c.rate_factor, "Factor on all rates from then on.").range(0, 1);
}

void describe(Describer& d, PhasesConfig& c) {
  d.group("diffuse", c.diffuse, "The diffuse layer alone.");
  d.group("reflection", c.reflection, "What mirrors and polished metal show.");
  d.group("transmittance", c.transmittance, "What is seen through glass.");
  d.group("joint", c.joint, "All layers together.");
}

PhasesConfig::PhasesConfig() {
  reflection.share = 0.1;
  reflection.hull_points = 1000;
  transmittance.from = 0.15;
  transmittance.share = 0.15;
  transmittance.initial_surfels = 100000;
}

std::string phases_problem(const PhasesConfig& c) {
  for (LayerKind kind : {LayerKind::Reflection, LayerKind::Transmittance}) {
    const LayerPhase& p = c.of(kind);
    for (const auto& [option, value] : {std::pair<const char*, double>{"until", p.until}, {"densify_until", p.densify_until}})
      if (value < p.from)
        return fmt::format("phases.{0}.{1} must not be smaller than phases.{0}.from", vitrine::name(kind), option);
  }
  if (c.reflection.share + c.transmittance.share > 0.95)
    return "phases.reflection.share and phases.transmittance.share leave nothing for the diffuse layer";
  return {};
}

LayerChoice chosen_layers(const std::string& wanted, bool has_specular_mask, bool has_transparent_mask) {
  if (wanted == "diffuse") return {};
  if (wanted == "reflection") return {.reflection = true, .transmittance = false};
  if (wanted == "full") return {.reflection = true, .transmittance = true};
  return {.reflection = has_specular_mask || has_transparent_mask, .transmittance = has_transparent_mask};
}

ImageOptions PhaseClock::image_options(const ShadingConfig& shading, Backend backend, int sh_degree) const {
  const ReflectionPhase& reflection = config_.reflection;
  const bool rough = fraction_ >= reflection.roughness_from;
  const Lobe lobe = !rough || shading.lobe == "mirror" ? Lobe::Mirror : shading.lobe == "cone" ? Lobe::Cone : Lobe::Sampled;
  const TracerBackend tracer = backend == Backend::Reference ? TracerBackend::Reference : TracerBackend::Embree;
  ImageOptions o;
  o.diffuse = {.backend = backend, .sh_degree = sh_degree};
  o.surface.ray_budget = shading.ray_budget;
  o.surface.normal_gradient = o.surface.depth_gradient = fraction_ >= reflection.surface_from;
  o.shape.silhouettes = shading.silhouettes && fraction_ >= reflection.silhouettes_from;
  o.reflection.backend = o.transmission.backend = tracer;
  o.reflection.sh_degree = reflection.sh_degree;
  o.reflection.lobe = lobe;
  o.transmission.glass = shading.glass == "thin" ? Glass::Thin : Glass::Traced;
  o.transmission.sh_degree = config_.transmittance.sh_degree;
  o.composite.blend = shading.blend == "rtrgs" ? LayerBlend::RtrGs : LayerBlend::Layered;
  o.composite.gate = static_cast<float>(shading.gate);
  o.composite.diffuse_in_transparent = static_cast<float>(shading.diffuse_in_transparent);
  return o;
}

double PhaseClock::ramp(const LayerPhase& phase) const {
  return phase.ramp > 0 ? std::clamp((fraction_ - phase.from) / phase.ramp, 0.0, 1.0) : 1;
}

AttributeRates PhaseClock::diffuse_rates(const RatesConfig& rates, double scene_radius) const {
  AttributeRates r = rates_at(rates, fraction_, scene_radius);
  const auto scale = [&](Attribute a, double factor) { r[static_cast<size_t>(a)] *= static_cast<float>(factor); };
  const bool reflection = training(LayerKind::Reflection), transmittance = training(LayerKind::Transmittance);
  for (Attribute a : {Attribute::F0, Attribute::SpecularWeight}) scale(a, reflection ? ramp(config_.reflection) : 0);
  scale(Attribute::Roughness, reflection && fraction_ >= config_.reflection.roughness_from ? ramp(config_.reflection) : 0);
  scale(Attribute::Transmission, transmittance ? ramp(config_.transmittance) : 0);
  double geometry = 1;
  if (begun(LayerKind::Reflection)) geometry = config_.reflection.geometry_factor;
  if (begun(LayerKind::Transmittance)) geometry = std::min(geometry, config_.transmittance.geometry_factor);
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale}) scale(a, geometry);
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
  } else if (training(kind)) {
    const LayerPhase& phase = config_.of(kind);
    r = rates_at(rates, fraction_, scene_radius);  // copies of what is trained already: no second start
    for (float& rate : r) rate *= static_cast<float>(ramp(phase));
  }
  if (layers_.any() && fraction_ >= config_.joint.from)
    for (float& rate : r) rate *= static_cast<float>(config_.joint.rate_factor);
  return r;
}

}  // namespace vitrine
