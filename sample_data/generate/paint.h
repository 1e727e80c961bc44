// Painted surfaces: patterns that never repeat and carry detail at several scales, which is what feature matching lives on.
// Sizes are metres.
#pragma once

#include <vector>

#include "sample_data/generate/texture.h"

namespace vitrine::generate {

using Palette = std::vector<Vec3f>;
Palette ceramic_palette();
Palette book_palette();

// Tiles with one glyph-like figure each (rings, crescents, stars, strokes, letters of no alphabet) in random colours.
Painting glyph_tiles(float tile, const Palette& palette, uint32_t seed);
// A picture for a wall: a graded ground under some dozens of discs, rings, bars and triangles.
Painting abstract_picture(float width, float height, uint32_t seed);
// Planks along x with grain, knots and worn varnish.
Painting planks(float plank, const Vec3f& light, const Vec3f& dark, uint32_t seed);
// Solid textures: wood along `axis` 0..2, and plaster with patches and specks.
Texture solid_wood(size_t axis, const Vec3f& light, const Vec3f& dark, uint32_t seed);
Texture plaster(const Vec3f& base, const Vec3f& stain, uint32_t seed);

}  // namespace vitrine::generate
