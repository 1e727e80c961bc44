// A family of test scenes: glass, metal, mirrors and coated paint among matt things on a table, all drawn by a seed. The parts of
// it: gallery_deck (which kinds), gallery_pieces (what they look like), gallery_layout (where they stand), gallery_views,
// gallery_room.
#include <cmath>

#include "core/foundation/base/error.h"
#include "sample_data/generate/scenes/gallery_draw.h"
#include "sample_data/generate/scenes/gallery_room.h"
#include "sample_data/generate/scenes/scenes.h"

namespace vitrine::generate {
namespace {

constexpr uint64_t kGainPurpose = 9;

Scene gallery_in(uint64_t seed, RoomPaint paint, GalleryPlan (*plan_of)(uint64_t) = gallery_plan) {
  if (seed == 0) throw Error(ErrorKind::Usage, "seeds of the gallery begin at 1", {.code = "USAGE"});
  Scene scene;
  GalleryPlan plan = plan_of(seed);
  add_gallery_room(scene, plan, seed, paint);
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

// Exposure within a sixth of a stop, red and blue within 8 %; the mean over the photos is 1 in log, as View::gain has it.
void drift_gains(std::vector<View>& views, uint64_t seed) {
  Draw draw(seed, kGainPurpose);
  Vec3d mean{};
  std::vector<Vec3d> logs;
  for (size_t i = 0; i < views.size(); ++i) {
    const double exposure = double(draw.between(-0.115f, 0.115f));
    logs.push_back({exposure + double(draw.between(-0.08f, 0.08f)), exposure, exposure + double(draw.between(-0.08f, 0.08f))});
    mean += logs.back() / double(views.size());
  }
  for (size_t i = 0; i < views.size(); ++i)
    for (size_t c = 0; c < 3; ++c) views[i].gain[c] = std::exp(logs[i][c] - mean[c]);
}

}  // namespace

Scene gallery(uint64_t seed) { return gallery_in(seed, RoomPaint::Patterned); }

Scene plain_gallery(uint64_t seed) {
  Scene scene = gallery_in(seed, RoomPaint::Plain);
  drift_gains(scene.views, seed);
  return scene;
}

Scene filled_gallery(uint64_t seed) { return gallery_in(seed, RoomPaint::Patterned, filled_plan); }

}  // namespace vitrine::generate
