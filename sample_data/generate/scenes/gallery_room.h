// The room of a gallery: painted walls with pictures, a floor, a table, lamps and three skies, all drawn by the seed.
#pragma once

#include "sample_data/generate/scenes/gallery_layout.h"

namespace vitrine::generate {

void add_gallery_room(Scene& scene, const GalleryPlan& plan, uint64_t seed);
void add_gallery_lights(Scene& scene, const GalleryPlan& plan, uint64_t seed);

}  // namespace vitrine::generate
