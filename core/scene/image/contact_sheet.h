// Contact sheets: rows of thumbnails with labels.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/image.h"

namespace vitrine {

class ContactSheet {
 public:
  // At most `columns` images per row, each at most `cell_width` pixels wide.
  explicit ContactSheet(int columns, int cell_width = 320) : columns_(columns), cell_width_(cell_width) {}

  // Starts a new row below a line of text (may be empty).
  void start_row(std::string label) { rows_.push_back({std::move(label), {}}); }
  // Stores a thumbnail. 1 or 3 channels; the title is printed above the image.
  void add(std::string title, const Image8& picture);

  Image8 picture() const;
  // Format by extension (write_ldr). Writes no file if there are no images.
  void write(const std::filesystem::path& path) const;

 private:
  struct Cell {
    std::string title;
    Image8 picture;
  };
  struct Row {
    std::string label;
    std::vector<Cell> cells;
  };
  int columns_, cell_width_;
  std::vector<Row> rows_;
};

// Built-in 5x7 bitmap font for image labels: no font dependency, identical output everywhere. Capitals, digits and common
// signs; lower case is drawn as capitals, other characters as a box.
constexpr int kGlyphAdvance = 6, kGlyphHeight = 7;  // pixels at scale 1

// Draws with the top left corner at (x, y), clipped to the image; `image` has three channels.
void draw_text(Image8& image, int x, int y, std::string_view text, int scale = 1, uint8_t level = 255);
int text_width(std::string_view text, int scale = 1);  // UTF-8: one glyph per character

}  // namespace vitrine
