#include "core/render/raster/device.h"
#include "core/render/raster/renderer.h"
#include "stages/optimize/blocks.h"
#include "stages/optimize/optimize.h"
#include "stages/training_cost.h"

namespace vitrine {

void describe(Describer& d, InitialConfig& c) {
  d.option("frustum_points", c.frustum_points, "Surfels placed along pixel rays, where the sparse points leave gaps.")
      .range(0, 10000000);
  d.option("stereo_side", c.stereo_side, "Longest side of the photos of dense stereo, about, pixels; more is finer and slower.")
      .range(32, 16384);
}

void describe(Describer& d, OptimizeConfig& c) {
  d.option("iterations", c.iterations, "Training steps; each looks at one photo.").range(1, 10000000);
  d.option("max_gaussians", c.max_gaussians,
           "Most surfels that all layers together may grow to; what no photo shows may take a fifth more, the opaque twin as "
           "many again.")
      .range(1, 100000000);
  d.choice("layers", c.layers, {"auto", "diffuse", "reflection", "full"},
           "diffuse: opaque scenes; reflection: mirrors too; full: glass too; auto: what the table of objects needs, without "
           "objects that are only guessed.");
  d.option(
      "opaque_twin", c.opaque_twin,
      "Trains a scene with glass or mirrors a second time, as opaque surfels alone: pictures of it as photographed are a mean of "
      "both, in which the better one of an object has more weight.");
  d.option("sh_degree", c.sh_degree, "View dependence of the colour: spherical harmonics up to this degree.").range(0, 3);
  d.option("max_side", c.max_side, "Longest side of the photos in training, pixels; larger photos are reduced.").range(16, 16384);
  d.choice("backend", c.backend, {"reference", "cpu"}, "cpu: tiles, vectors and threads; reference: the slow specification.");
  d.option("seed", c.seed, "Seed of all random numbers.").range(0, 2147483647);
  d.option("holdout_every", c.holdout_every, "Every how many photos one is kept from training for the evaluation; 0 = none.")
      .range(0, 100000);
  d.choice("surroundings", c.surroundings, {"auto", "train", "ignore"},
           "What masks of the object leave out: train it like everything else, ignore it (the object alone), or auto: ignore "
           "what does not stand still with the object (the room around a turntable, a plain backdrop, all passes in which it was "
           "turned over) and train the rest. With passes, train uses the photos of the largest one.");
  d.choice("medium", c.medium, {"off", "water", "haze", "auto"},
           "What fills the space between cameras and surfaces: water (each colour is absorbed and scattered on its own), haze (one "
           "coefficient), or auto: what explains left-out photos, else nothing. The trained scene is the one without it.");
  d.choice(
      "transients", c.transients, {"auto", "off"},
      "auto: what one photo shows and the others contradict, such as a visitor, is found by a short training and not trained "
      "on, where no ignore masks are given; off: it is trained like everything else.");
  d.choice("poses", c.poses, {"given", "auto"},
           "given: as the sfm stage found them; auto: training corrects the pose of each photo, where it trains one opaque layer; "
           "all later stages use the corrected ones.");
  d.option("fill_unseen", c.fill_unseen,
           "Close gaps in what surrounds the capture that no photo shows, with the smoothest continuation; and those that photos "
           "show through thin glass alone.");
  d.option(
       "blocks", c.blocks,
       "Split the capture by place into this many blocks, which are trained one after the other and joined: takes the memory of "
       "the largest one. One opaque layer only.")
      .range(1, 1000);
  d.option("checkpoint_every", c.checkpoint_every, "Steps between two checkpoints; 0 = only on interruption.")
      .range(0, 10000000)
      .affects_output(false);
  d.option("rate_factor", c.rates.factor, "Factor on all step sizes of Adam; lower it where training diverges.").range(1e-3, 100);
  d.choice(
      "densify", c.densify.strategy, {"divide", "classic", "none"},
      "divide: relocate idle surfels and grow to the cap, a copy halves its parent; classic: clone, split and prune (Kerbl et "
      "al. 2023); none.");
  d.group("initial", c.initial, "The surfels that training starts from.");
  d.group("shading", c.shading, "How the layers become a picture.");
  d.group("loss", c.loss, "Weights of the losses; 0 switches one off.");
}

Stage optimize_stage() {
  StageInfo info{.name = "optimize",
                 .version = 41,
                 .summary = "trains the surfels of all layers on the photos",
                 .inputs = {{.name = "sfm", .doc = "Calibrated, undistorted photos and sparse points."},
                            {.name = "masks", .optional = true, .doc = "The object, and what to ignore."},
                            {.name = "objects", .optional = true, .doc = "Glass, mirrors and coats: labels and shapes."},
                            {.name = "normals", .optional = true, .doc = "Normals seen by each photo."}},
                 .doing = "training",
                 .cost = optimize_cost,
                 .report = optimize_report(),
                 .device = kRasterDevice};
  Stage stage = make_stage<OptimizeConfig>(
      std::move(info), run_optimize,
      [] {
        return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
      },
      blocks_problem);
  stage.fit = optimize_fit();
  return stage;
}

StageCost optimize_cost(const CostTerms& t) {
  constexpr double kLayeredPart = 0.55;
  const double steps = t.number("optimize.iterations");
  const bool twin = t.capture.masks && t.text("optimize.opaque_twin") == "true" && t.text("optimize.layers") != "diffuse";
  const double step_s = training_step_s(t, kLayeredPart, "optimize.shading.ray_budget") + (twin ? opaque_step_s(t) : 0);
  // A block has its own photos and some of its neighbours; all blocks together take the steps of the photos that they share.
  constexpr double kShared = 1.6;
  const double blocks = t.number("optimize.blocks"), photos = blocks > 1 ? kShared : 1;
  return stage_cost(photos * (0.7 * t.photos() + steps * step_s), 0.92, training_memory_mib(t) * std::min(1.0, photos / blocks),
                    (twin ? 2 : 1) * trained_surfels_disk_mib(t));
}

StageReport optimize_report() {
  constexpr const char* kViews = "Pictures from new places";
  StageReport report{.file = "optimize/report.json"};
  report.facts = {{kViews, "{layers.*.surfels:n} surfels (by layer: {layers.*.surfels:parts})", "surfels"},
                  {kViews, "{surfels:n} surfels", "surfels"},
                  {kViews, "{iterations:n} training steps"}};
  return report;
}

}  // namespace vitrine
