#include "core/render/renderer.h"
#include "stages/refine/refine.h"

namespace vitrine {

void describe(Describer& d, PruneConfig& c) {
  d.option("min_votes", c.min_votes, "A surfel goes when at least so many photos show the space around it to be empty.")
      .range(1, 100000);
  d.option("share", c.share, "And at least this share of the photos that see its place.").range(0, 1);
  d.option("inside_share", c.inside_share,
           "With exterior_set diffuse a surfel stays behind glass when at least this share of the rays through closed glass that "
           "pass it meets it inside.")
      .range(0, 1);
}

void describe(Describer& d, RefineConfig& c) {
  d.option("max_side", c.max_side, "Longest side of the photos and pictures, pixels; 0 = as the scene was trained.")
      .range(0, 16384);
  d.option("exterior_set", c.exterior_set,
           "What rays see that have left closed glass on its far side: transmittance (its layer among the rest of the room), "
           "diffuse (the room alone), auto: whichever the photos prefer.")
      .choices({"auto", "transmittance", "diffuse"});
  d.option("glass", c.glass,
           "Closed glass in the mesh: thin (a shell, rays go straight on), thick (solid, rays bend where they enter and leave), "
           "auto: "
           "per piece, whichever is nearer to photos that training never saw.")
      .choices({"auto", "thin", "thick"});
  d.option("ior", c.ior, "Index of refraction of thick glass.").range(1.01, 4);
  d.option("min_gain", c.min_gain, "The scene stays as it was unless glass gains so many dB in photos that training never saw.")
      .range(0, 10);
  d.option("min_agreement", c.min_agreement,
           "A photo's segments count when mesh and rendered depth agree on this share of its glass.")
      .range(0, 1);
  d.group("prune", c.prune, "Surfels of the transmittance layer that stand where the photos see through.");
  d.group("fine_tune", c.fine_tune, "A short training of all layers afterwards.");
}

Stage refine_stage() {
  StageInfo info{
      .name = "refine",
      .version = 17,
      .summary = "puts what stands behind glass in order, with the mesh",
      .inputs = {{.name = "sfm", .doc = "Cameras, gains and undistorted photos."},
                 {.name = "masks", .optional = true, .doc = "The object, and what is to be ignored."},
                 {.name = "objects", .optional = true, .doc = "Where glass is; without it, where surfels are transparent."},
                 {.name = "optimize", .doc = "The trained surfels and the list of held-out views."},
                 {.name = "mesh", .doc = "The surfaces through which rays enter and leave glass."}},
      .doing = "putting in order what stands behind glass",
      .cost = refine_cost,
      .report = refine_report()};
  return make_stage<RefineConfig>(std::move(info), run_refine, [] {
    return std::map<std::string, std::string>{{"renderer", std::string(make_renderer(Backend::Cpu)->numerics_tag())}};
  });
}

}  // namespace vitrine
