#include "core/render/raster/device.h"
#include "core/render/raster/renderer.h"
#include "stages/refine/refine.h"
#include "stages/training_cost.h"

namespace vitrine {

void describe(Describer& d, RefineConfig& c) {
  d.option("max_side", c.max_side, "Longest side of the photos and pictures, pixels; 0 = as the scene was trained.")
      .range(0, 16384);
  d.choice("exterior_set", c.exterior_set, {"auto", "transmittance", "diffuse"},
           "What rays see that have left closed glass on its far side: transmittance (its layer among the rest of the room), "
           "diffuse (the room alone), auto: whichever the photos prefer.");
  d.choice("glass", c.glass, {"auto", "thin", "thick"},
           "Closed glass in the mesh: thin (a shell, rays go straight on), thick (solid, rays bend where they enter and leave), "
           "auto: per piece, whichever is nearer to the held-out photos.");
  d.option("ior", c.ior, "Index of refraction of thick glass.").range(1.01, 4);
  d.group("fine_tune", c.fine_tune, "A short training of all layers afterwards.");
}

Stage refine_stage() {
  StageInfo info{
      .name = "refine",
      .version = 18,
      .summary = "puts what stands behind glass in order, with the mesh",
      .inputs = {{.name = "sfm", .doc = "Cameras, gains and undistorted photos."},
                 {.name = "masks", .optional = true, .doc = "The object, and what is to be ignored."},
                 {.name = "objects", .optional = true, .doc = "Where glass is; without it, where surfels are transparent."},
                 {.name = "optimize", .doc = "The trained surfels and the list of held-out views."},
                 {.name = "mesh", .doc = "The surfaces through which rays enter and leave glass."}},
      .doing = "putting in order what stands behind glass",
      .cost = refine_cost,
      .report = refine_report(),
      .device = kRasterDevice};
  return make_stage<RefineConfig>(std::move(info), run_refine, [] {
    return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
  });
}

// Upper bound: the stage works on glass only, and the content of the masks is unknown before the run.
StageCost refine_cost(const CostTerms& t) {
  if (!t.capture.masks) return stage_cost(0.1, 0.5, 90, 0.1);
  const double steps = t.number("refine.fine_tune.iterations");
  return stage_cost(0.6 * t.photos() + steps * training_step_s(t, 1, "refine.fine_tune.ray_budget"), 0.92,
                    1.05 * training_memory_mib(t), trained_surfels_disk_mib(t));
}

StageReport refine_report() {
  StageReport report{.file = "refine/report.json"};
  report.facts = {
      {.group = "Light and materials",
       .text = "the glass looks {verdict=thin,thick} (straight rays show what is behind it at "
               "{psnr.straight,psnr.straight_without_layer:1} dB, refracted ones at {psnr.bent,psnr.bent_without_layer:1} dB)",
       .each = "glass.regions"}};
  return report;
}

}  // namespace vitrine
