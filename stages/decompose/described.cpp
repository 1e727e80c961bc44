#include "core/render/raster/renderer.h"
#include "stages/decompose/decompose.h"

namespace vitrine {

void describe(Describer& d, DecomposeConfig& c) {
  d.option("points", c.points, "Surface points on the mesh at which irradiance is found, about.").range(100, 100000);
  d.option("panorama_height", c.panorama_height, "Rows of the panorama of the surroundings and of environment.exr.")
      .range(16, 512);
  d.option(
       "sky_distance", c.sky_distance,
       "Surroundings farther than this from the centre are light, not walls; scene units (the cameras' ring has radius 1); 0 = "
       "what lies clearly beyond all sparse points.")
      .range(0, 1e6);
  d.option("white_albedo", c.white_albedo, "By convention the brightest twentieth of the surface has this albedo.")
      .range(0.05, 0.95);
  d.option("grey_card", c.grey_card,
           "A card of known albedo, \"photo:x,y,w,h\" in pixels of the undistorted photo; empty: scale by convention.");
  d.option("grey_albedo", c.grey_albedo, "Albedo of the grey card.").range(0.01, 0.98);
  d.option("seed", c.seed, "Of the jitter of rays.").range(0, 1e9);
}

Stage decompose_stage() {
  return make_stage<DecomposeConfig>(
      {.name = "decompose",
       .version = 16,
       .summary = "takes the diffuse colours apart into albedo and light",
       .inputs = {{.name = "sfm", .doc = "Cameras, gains and undistorted photos."},
                  {.name = "optimize", .doc = "The trained surfels and their training views."},
                  {.name = "refine", .optional = true, .doc = "Better surfels behind glass."},
                  {.name = "mesh", .doc = "What casts shadows."},
                  {.name = "objects",
                   .optional = true,
                   .doc = "Glass, mirrors and coats, whose pixels do not determine the light."}},
       .doing = "separating colour and light",
       .cost = decompose_cost,
       .report = decompose_report()},
      run_decompose, [] {
        return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
      });
}

StageCost decompose_cost(const CostTerms& t) { return stage_cost(14 + 0.2 * t.photos(), 0.77, 350 + 4 * t.photos(), 6); }

StageReport decompose_report() {
  StageReport report{.file = "decompose/report.json"};
  report.figures = {{"Light and materials", "baked", "Light that stays baked in", "log", 2, 0.3, 0.6,
                     "Photo against albedo times light, rms of the logarithm: what a new light will not move. Mirrors, coats and "
                     "glass above all.",
                     "Highlights and what glass shows keep the light of the photos under a new one.", "baked_log_rms"},
                    ReportFigure{"Light and materials", "misfit", "Light and albedo against the colours", "log", 2, 0.3, 0.6,
                                 "What albedo times light leaves unexplained on the surface, rms of the logarithm.",
                                 "Shadows or colours of the light may have ended in the albedo.", "misfit_log_rms.*"}
                        .folded("last")};
  return report;
}

}  // namespace vitrine
