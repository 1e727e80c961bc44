// The room of a gallery: walls, a floor, a table, lamps and three skies, all drawn by the seed.
#pragma once

#include "sample_data/generate/scenes/gallery_layout.h"

namespace vitrine::generate {

enum class RoomPaint {
  Patterned,  // plaster, tiles or planks, and pictures on the walls
  Plain       // walls and floor of one colour each, nothing on them: no stereo finds them
};
void add_gallery_room(Scene& scene, const GalleryPlan& plan, uint64_t seed, RoomPaint paint);
void add_gallery_lights(Scene& scene, const GalleryPlan& plan, uint64_t seed);

}  // namespace vitrine::generate
