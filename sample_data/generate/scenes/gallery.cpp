// A family of test scenes: glass, metal, mirrors and coated paint among matt things on a table, all drawn by a seed. The parts of
// it: gallery_deck (which kinds), gallery_pieces (what they look like), gallery_layout (where they stand), gallery_views,
// gallery_room.
#include "core/base/error.h"
#include "sample_data/generate/scenes/gallery_room.h"
#include "sample_data/generate/scenes/scenes.h"

namespace vitrine::generate {

Scene gallery(uint64_t seed) {
  if (seed == 0) throw Error(ErrorKind::Usage, "seeds of the gallery begin at 1", {.code = "USAGE"});
  Scene scene;
  GalleryPlan plan = gallery_plan(seed);
  add_gallery_room(scene, plan, seed);
  add_gallery_lights(scene, plan, seed);
  add_gallery_views(scene, plan, seed);
  for (PlacedPiece& placed : plan.pieces)
    for (Part& part : placed.piece.parts) scene.parts.push_back(std::move(part));
  scene.sensor.jpeg_quality = 95;
  scene.samples = 16;
  scene.relit_samples = 1;
  scene.transmitted_samples = 0.5f;
  scene.cache = {.direct_samples = 64, .gather_samples = 32, .passes = 2};
  scene.full_truth = true;
  scene.marked = true;
  scene.relit_every = 6;
  scene.transmitted_every = 1;
  return scene;
}

}  // namespace vitrine::generate
