// Colours and solid patterns of the gallery's painted things, drawn by the seed. Every pattern has detail at several scales:
// `size` (metres) is the largest, the finest is about a tenth of it.
#pragma once

#include "sample_data/generate/scenes/gallery_draw.h"

namespace vitrine::generate {

Palette drawn_palette(Draw& draw, int colours);
Vec3f drawn_metal_colour(Draw& draw);  // reflectance at normal incidence

Texture patchwork(const Palette& palette, float size, uint32_t seed);   // cells of one colour each
Texture banded(const Palette& palette, float size, uint32_t seed);      // zigzag bands around the vertical axis, and dots
Texture marbled(const Palette& palette, float size, uint32_t seed);     // veins of folded noise
Texture speckled(const Palette& palette, float size, uint32_t seed);    // a ground with specks of two sizes
Texture solid_pattern(Draw& draw, const Palette& palette, float size);  // one of them
Texture flat_pattern(Draw& draw, const Palette& palette, float size);   // tiles on the uv of a flat part
Texture wooden(Draw& draw, size_t axis);                                // light or dark wood along an axis

}  // namespace vitrine::generate
