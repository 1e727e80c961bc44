#include "core/scene/image/contact_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

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

namespace {

struct Glyph {
  char letter;
  std::array<unsigned char, kGlyphHeight> rows;  // five bits each, leftmost = most significant
};

constexpr Glyph kGlyphs[] = {
    {' ', {0, 0, 0, 0, 0, 0, 0}},
    {'A', {0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001}},
    {'B', {0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110}},
    {'C', {0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110}},
    {'D', {0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110}},
    {'E', {0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111}},
    {'F', {0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000}},
    {'G', {0b01110, 0b10001, 0b10000, 0b10111, 0b10001, 0b10001, 0b01110}},
    {'H', {0b10001, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001}},
    {'I', {0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'J', {0b00111, 0b00010, 0b00010, 0b00010, 0b00010, 0b10010, 0b01100}},
    {'K', {0b10001, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010, 0b10001}},
    {'L', {0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111}},
    {'M', {0b10001, 0b11011, 0b10101, 0b10101, 0b10001, 0b10001, 0b10001}},
    {'N', {0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001, 0b10001}},
    {'O', {0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'P', {0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000}},
    {'Q', {0b01110, 0b10001, 0b10001, 0b10001, 0b10101, 0b10010, 0b01101}},
    {'R', {0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001}},
    {'S', {0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110}},
    {'T', {0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100}},
    {'U', {0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'V', {0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100}},
    {'W', {0b10001, 0b10001, 0b10001, 0b10101, 0b10101, 0b11011, 0b10001}},
    {'X', {0b10001, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001, 0b10001}},
    {'Y', {0b10001, 0b10001, 0b01010, 0b00100, 0b00100, 0b00100, 0b00100}},
    {'Z', {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b11111}},
    {'0', {0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110}},
    {'1', {0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'2', {0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111}},
    {'3', {0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110}},
    {'4', {0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010}},
    {'5', {0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110}},
    {'6', {0b01110, 0b10000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110}},
    {'7', {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000}},
    {'8', {0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110}},
    {'9', {0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00001, 0b01110}},
    {'.', {0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100}},
    {',', {0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b00100, 0b01000}},
    {':', {0b00000, 0b01100, 0b01100, 0b00000, 0b01100, 0b01100, 0b00000}},
    {'-', {0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000}},
    {'_', {0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b11111}},
    {'+', {0b00000, 0b00100, 0b00100, 0b11111, 0b00100, 0b00100, 0b00000}},
    {'=', {0b00000, 0b00000, 0b11111, 0b00000, 0b11111, 0b00000, 0b00000}},
    {'/', {0b00001, 0b00010, 0b00010, 0b00100, 0b01000, 0b01000, 0b10000}},
    {'%', {0b11001, 0b11001, 0b00010, 0b00100, 0b01000, 0b10011, 0b10011}},
    {'(', {0b00010, 0b00100, 0b01000, 0b01000, 0b01000, 0b00100, 0b00010}},
    {')', {0b01000, 0b00100, 0b00010, 0b00010, 0b00010, 0b00100, 0b01000}},
};
constexpr Glyph kUnknown{'?', {0b11111, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11111}};

const Glyph& glyph(char letter) {
  const char capital = letter >= 'a' && letter <= 'z' ? char(letter - 'a' + 'A') : letter;
  const auto it = std::find_if(std::begin(kGlyphs), std::end(kGlyphs), [&](const Glyph& g) { return g.letter == capital; });
  return it != std::end(kGlyphs) ? *it : kUnknown;
}

bool continues_character(char byte) { return (static_cast<unsigned char>(byte) & 0xC0) == 0x80; }  // UTF-8

}  // namespace

int text_width(std::string_view text, int scale) {
  const auto letters = std::count_if(text.begin(), text.end(), [](char c) { return !continues_character(c); });
  return int(letters) * kGlyphAdvance * scale;
}

void draw_text(Image8& image, int x, int y, std::string_view text, int scale, uint8_t level) {
  for (char letter : text) {
    if (continues_character(letter)) continue;
    const Glyph& g = glyph(letter);
    for (int j = 0; j < kGlyphHeight * scale; ++j)
      for (int i = 0; i < 5 * scale; ++i) {
        if (((g.rows[size_t(j / scale)] >> (4 - i / scale)) & 1) == 0) continue;
        if (x + i < 0 || x + i >= image.width() || y + j < 0 || y + j >= image.height()) continue;
        for (int c = 0; c < image.channels(); ++c) image.at(x + i, y + j, c) = level;
      }
    x += kGlyphAdvance * scale;
  }
}

}  // namespace vitrine
