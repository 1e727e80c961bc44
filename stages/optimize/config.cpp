#include "core/render/renderer.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

void describe(Describer& d, ResolutionConfig& c) {
  d.option("max_side", c.max_side, "Longest side of the photos in training, pixels; larger photos are reduced.").range(16, 16384);
  d.option("quarter_until", c.quarter_until, "Part of the run that trains on quarter-size photos.").range(0, 1);
  d.option("half_until", c.half_until, "Part of the run after which half-size gives way to full size.").range(0, 1);
}

void describe(Describer& d, InitialConfig& c) {
  d.option("frustum_points", c.frustum_points, "Surfels placed along pixel rays, where the sparse points leave gaps.")
      .range(0, 10000000);
  d.option("far_factor", c.far_factor,
           "How far beyond the farthest sparse points surfaces are looked for; what no surface there explains may be sky.")
      .range(1, 100);
  d.option("stereo_side", c.stereo_side,
           "Longest side of the photos that are matched for depth, about; more is finer and slower.")
      .range(32, 16384);
  d.option("opacity", c.opacity, "Opacity of the first surfels.").range(0.01, 0.99);
  d.option("scale", c.scale, "Scale of the first surfels, relative to the distance of their neighbours.").range(0.05, 5);
}

void describe(Describer& d, OptimizeConfig& c) {
  d.option("iterations", c.iterations, "Training steps; each looks at one photo.").range(1, 10000000);
  d.option("max_gaussians", c.max_gaussians,
           "Most surfels that all layers together may grow to; what no photo shows may take a fifth more, the opaque twin as "
           "many again.")
      .range(1, 100000000);
  d.option(
       "layers", c.layers,
       "diffuse: opaque scenes; reflection: mirrors and gloss too; full: glass too; auto: what masks ask for that are not mere "
       "proposals.")
      .choices({"auto", "diffuse", "reflection", "full"});
  d.option(
      "opaque_twin", c.opaque_twin,
      "Trains a scene with glass or gloss a second time, as opaque surfels alone: pictures of it as photographed are a mean of "
      "both, in which the better one of an object has more weight.");
  d.option("sh_degree", c.sh_degree, "View dependence of the colour: spherical harmonics up to this degree.").range(0, 3);
  d.option("sh_from", c.sh_from, "Part of the run after which the colour may depend on the view.").range(0, 1);
  d.option("backend", c.backend, "cpu: tiles, vectors and threads; reference: the slow specification.")
      .choices({"cpu", "reference"});
  d.option("seed", c.seed, "Seed of all random numbers.").range(0, 2147483647);
  d.option("holdout_every", c.holdout_every, "Every how many photos one is kept from training for the evaluation; 0 = none.")
      .range(0, 100000);
  d.option("surroundings", c.surroundings,
           "What masks of the object leave out: train it like everything else, ignore it (the object alone), or auto: ignore "
           "what does not stand still with the object (the room around a turntable, a plain backdrop, all passes in which it was "
           "turned over) and train the rest. With passes, train uses the photos of the largest one.")
      .choices({"auto", "train", "ignore"});
  d.option("fill_unseen", c.fill_unseen,
           "Close gaps in what surrounds the capture that no photo shows, with the smoothest continuation; and those that photos "
           "show through thin glass alone.");
  d.option("preview_every", c.preview_every, "Steps between two preview pictures; 0 = only the last.").range(0, 10000000);
  d.option("checkpoint_every", c.checkpoint_every, "Steps between two checkpoints; 0 = only on interruption.")
      .range(0, 10000000)
      .affects_output(false);
  d.group("resolution", c.resolution, "Sizes of the photos, coarse to fine.");
  d.group("initial", c.initial, "The surfels that training starts from.");
  d.group("phases", c.phases, "Which layer is trained when, as parts of the run.");
  d.group("shading", c.shading, "How the layers become a picture.");
  d.group("rates", c.rates, "Step sizes of Adam.");
  d.group("densify", c.densify, "Where surfels are added, moved and dropped.");
  d.group("loss", c.loss, "What training makes small.");
}

namespace {

std::string config_problem(const OptimizeConfig& c) {
  if (c.resolution.half_until < c.resolution.quarter_until)
    return "resolution.half_until must not be smaller than resolution.quarter_until";
  if (c.densify.until < c.densify.from) return "densify.until must not be smaller than densify.from";
  for (const LossTerm& term : c.loss.terms())
    if (term.schedule.until < term.schedule.from)
      return fmt::format("loss.{0}.until must not be smaller than loss.{0}.from", term.factory->name);
  return phases_problem(c.phases);
}

}  // namespace

Stage optimize_stage() {
  StageInfo info{.name = "optimize",
                 .version = 36,
                 .summary = "trains the surfels of all layers on the photos",
                 .inputs = {{.name = "sfm", .doc = "Calibrated, undistorted photos and sparse points."},
                            {.name = "masks", .optional = true, .doc = "The object, and what to ignore."},
                            {.name = "objects", .optional = true, .doc = "Glass, mirrors and coats: labels and shapes."},
                            {.name = "normals", .optional = true, .doc = "Normals seen by each photo."}},
                 .doing = "training",
                 .cost = optimize_cost,
                 .report = optimize_report()};
  return make_stage<OptimizeConfig>(
      std::move(info), run_optimize,
      [] {
        return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
      },
      config_problem);
}

}  // namespace vitrine
