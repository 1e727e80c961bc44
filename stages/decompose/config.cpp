// The options of the decompose stage, and what it reads.
#include "stages/decompose/decompose.h"

#include "core/render/renderer.h"

namespace vitrine {

void describe(Describer& d, DecomposeSolverConfig& c) {
  d.option("points", c.points, "Surface points that the light is solved with.").range(64, 20000);
  d.option("rounds", c.rounds, "Turns of albedo and light.").range(0, 1000);
  d.option("ridge", c.ridge, "Pull of every light cell towards the mean light.").range(0, 1e3);
  d.option("smooth", c.smooth, "Pull of neighbouring light cells towards each other.").range(0, 1e3);
  d.option("range_sigma", c.range_sigma, "Log albedos that differ by much more count as different paint.").range(1e-3, 100);
  d.option("chroma_sigma", c.chroma_sigma, "Chromaticities that differ by much more count as different paint.").range(1e-3, 10);
}

void describe(Describer& d, DecomposeConfig& c) {
  d.option("points", c.points, "Surface points on the mesh at which irradiance is found, about.").range(100, 100000);
  d.option("bands", c.bands, "Light cells from zenith to nadir; twice as many around.").range(4, 32);
  d.option("max_side", c.max_side, "Longest side of the pictures that surface points are taken from, pixels.").range(32, 2048);
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
  d.option("sheet_rows", c.sheet_rows, "Views on albedo.png and baked.png.").range(0, 32);
  d.option("sheet_cell_width", c.sheet_cell_width, "Width of a picture on them, pixels.").range(32, 1024);
  d.option("seed", c.seed, "Of the jitter of rays.").range(0, 1e9);
  d.group("solver", c.solver, "How light and albedo are told apart.");
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

}  // namespace vitrine
