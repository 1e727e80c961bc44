#include "core/scene/image/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/scene/image/bitmap_font.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr int kSheetGap = 4, kTextMargin = 6, kTextScale = 2;  // pixels, pixels, font scale
constexpr int kTextBar = kGlyphHeight * kTextScale + 2 * kTextMargin;
constexpr uint8_t kSheetGrey = 24, kTitleGrey = 200, kLabelGrey = 255;

void paste(const Image8& picture, int left, int top, Image8& sheet) {
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < 3; ++c) sheet.at(left + x, top + y, c) = picture.at(x, y, std::min(c, picture.channels() - 1));
}

}  // namespace

void ContactSheet::add(std::string title, const Image8& picture) {
  if (rows_.empty()) start_row({});
  const int width = std::min(cell_width_, picture.width());
  const int height = std::max(1, int(std::lround(double(picture.height()) * width / picture.width())));
  rows_.back().cells.push_back(
      {std::move(title), width == picture.width() ? picture : bytes_of(resized(floats_of(picture), width, height))});
}

Image8 ContactSheet::picture() const {
  int columns = 1, width = 1;
  for (const Row& row : rows_) {
    columns = std::max(columns, std::min(columns_, int(row.cells.size())));
    for (const Cell& cell : row.cells) width = std::max(width, cell.picture.width());
  }
  std::vector<Image8> strips;  // stacked vertically
  const auto strip = [&](int height) -> Image8& {
    return strips.emplace_back(columns * (width + kSheetGap) + kSheetGap, height, 3, kSheetGrey);
  };
  for (const Row& row : rows_) {
    if (!row.label.empty()) draw_text(strip(kTextBar), kSheetGap, kTextMargin, row.label, kTextScale, kLabelGrey);
    for (size_t first = 0; first < row.cells.size(); first += size_t(columns)) {
      const auto line = std::span(row.cells).subspan(first, std::min(size_t(columns), row.cells.size() - first));
      Image8& titles = strip(kTextBar);
      int height = 0, left = kSheetGap;
      for (const Cell& cell : line) {
        draw_text(titles, left, kTextMargin, cell.title, kTextScale, kTitleGrey);
        height = std::max(height, cell.picture.height());
        left += width + kSheetGap;
      }
      Image8& pictures = strip(height + kSheetGap);
      left = kSheetGap;
      for (const Cell& cell : line) {
        paste(cell.picture, left, 0, pictures);
        left += width + kSheetGap;
      }
    }
  }
  int height = 0;
  for (const Image8& s : strips) height += s.height();
  Image8 sheet(columns * (width + kSheetGap) + kSheetGap, height, 3);
  auto to = sheet.data().begin();
  for (const Image8& s : strips) to = std::ranges::copy(s.data(), to).out;
  return sheet;
}

void ContactSheet::write(const std::filesystem::path& path) const {
  if (std::ranges::any_of(rows_, [](const Row& row) { return !row.cells.empty(); })) write_ldr(path, picture());
}

}  // namespace vitrine
