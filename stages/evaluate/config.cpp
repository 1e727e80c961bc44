// The options of the evaluate stage, and what it reads.
#include "stages/evaluate/evaluate.h"

#include "core/render/renderer.h"

namespace vitrine {

void describe(Describer& d, EvaluateConfig& c) {
  d.option("backend", c.backend, "Renderer: cpu, or reference (slow, double precision).").choices({"cpu", "reference"});
  d.option("score_train_views", c.score_train_views, "Score the training views too, for reference.");
  d.option("write_pictures", c.write_pictures, "Write photo, render and error of every held-out view.");
  d.option("write_layers", c.write_layers, "Write the layers of the views on the contact sheet, where there is more than one.");
  d.option("samples", c.samples, "Rays that a rough pixel reflects; 0 = the way the scene was trained.").range(0, 4096);
  d.option("relit_samples", c.relit_samples, "Samples of a pixel under the truth's other lights; 0 = not measured.")
      .range(0, 4096);
  d.option("relit_views", c.relit_views, "Views to look at under each of the truth's other lights.").range(1, 10000);
  d.option("mesh_threshold_rel", c.mesh_threshold_rel, "Distance that counts as hit, relative to the truth's diagonal.")
      .range(1e-6, 1);
}

Stage evaluate_stage() {
  StageInfo info;
  info.name = "evaluate";
  info.version = 28;
  info.summary = "scores held-out views, and geometry where there is truth";
  info.inputs = {
      {.name = "sfm", .doc = "cameras, gains and undistorted photos"},
      {.name = "masks", .optional = true, .doc = "the object, to score apart, and what is to be ignored"},
      {.name = "objects", .optional = true, .doc = "glass, mirrors and coats to score apart, where the truth has none"},
      {.name = "optimize", .doc = "the trained surfels and the list of held-out views"},
      {.name = "refine", .optional = true, .doc = "better surfels behind glass"},
      {.name = "mesh", .optional = true, .doc = "the mesh, to compare with the truth's"},
      {.name = "decompose", .optional = true, .doc = "albedo and light, to compare with the truth's"},
      {.name = "truth", .artifact = false, .optional = true, .doc = "truth folder (README: layout)"}};
  info.doing = "measuring";
  info.cost = evaluate_cost;
  info.report = evaluate_report();
  return make_stage<EvaluateConfig>(std::move(info), run_evaluate, [] {
    return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
  });
}

}  // namespace vitrine
