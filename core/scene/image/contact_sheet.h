// Contact sheets: rows of small pictures with labels, for people to look at.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/image/image.h"

namespace vitrine {

class ContactSheet {
 public:
  // At most `columns` pictures side by side, each at most `cell_width` pixels wide.
  explicit ContactSheet(int columns, int cell_width = 320) : columns_(columns), cell_width_(cell_width) {}

  // A line of text, which may be empty; the next picture begins a new line below it.
  void start_row(std::string label) { rows_.push_back({std::move(label), {}}); }
  // Keeps a small copy. 1 or 3 channels; the title stands above the picture.
  void add(std::string title, const Image8& picture);

  Image8 picture() const;
  // Format by extension (write_ldr). No file when there is no picture.
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

}  // namespace vitrine
