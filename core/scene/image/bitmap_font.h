// Built-in 5x7 bitmap font for image labels: no font dependency, identical output everywhere. Capitals, digits and common
// signs; lower case is drawn as capitals, other characters as a box.
#pragma once

#include <string_view>

#include "core/scene/image/image.h"

namespace vitrine {

constexpr int kGlyphAdvance = 6, kGlyphHeight = 7;  // pixels at scale 1

// Draws with the top left corner at (x, y), clipped to the image; `image` has three channels.
void draw_text(Image8& image, int x, int y, std::string_view text, int scale = 1, uint8_t level = 255);
int text_width(std::string_view text, int scale = 1);  // UTF-8: one glyph per character

}  // namespace vitrine
