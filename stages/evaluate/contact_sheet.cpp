#include "stages/evaluate/contact_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/image/bitmap_font.h"
#include "core/image/ldr.h"
#include "core/image/resample.h"
#include "core/math/quantile.h"

namespace vitrine {
namespace {

constexpr int kGap = 4, kMargin = 6, kTextScale = 2;
constexpr double kDepthLow = 0.02, kDepthHigh = 0.98;
// Dark to light with rising luminance, so that it reads in grey as well.
constexpr std::array<std::array<double, 3>, 6> kRamp{
    {{0, 0, 0}, {0.22, 0.05, 0.42}, {0.62, 0.13, 0.45}, {0.93, 0.38, 0.22}, {0.99, 0.76, 0.22}, {1, 1, 0.92}}};

uint8_t byte_of(double v) { return uint8_t(std::lround(std::clamp(v, 0.0, 1.0) * 255)); }

void paint_ramp(double t, uint8_t* rgb) {
  const double position = std::clamp(t, 0.0, 1.0) * double(kRamp.size() - 1);
  const size_t i = std::min(size_t(position), kRamp.size() - 2);
  const double f = position - double(i);
  for (size_t c = 0; c < 3; ++c) rgb[c] = byte_of((1 - f) * kRamp[i][c] + f * kRamp[i + 1][c]);
}

void paste(const Image8& picture, int x, int y, int width, int height, Image8& sheet) {
  ImageF small = floats_of(picture);
  if (small.width() != width || small.height() != height) small = resized(small, width, height);
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i)
      for (int c = 0; c < 3; ++c) sheet.at(x + i, y + j, c) = byte_of(small.at(i, j, c));
}

}  // namespace

Image8 image8(const ImageF& srgb) {
  Image8 out(srgb.width(), srgb.height(), srgb.channels());
  for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] = byte_of(srgb.data()[i]);
  return out;
}

Image8 error_picture(const ImageF& srgb, const ImageF& photo, double white_at) {
  Image8 out(srgb.width(), srgb.height(), 3);
  for (size_t i = 0; i < srgb.pixel_count(); ++i) {
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) sum += std::abs(double(srgb.data()[3 * i + c]) - photo.data()[3 * i + c]);
    paint_ramp(sum / 3 / white_at, &out.data()[3 * i]);
  }
  return out;
}

Image8 normal_picture(const ImageF& normal) {
  Image8 out(normal.width(), normal.height(), 3);
  for (size_t i = 0; i < normal.pixel_count(); ++i) {
    const float* n = &normal.data()[3 * i];
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) continue;
    for (size_t c = 0; c < 3; ++c) out.data()[3 * i + c] = byte_of(0.5 * n[c] + 0.5);
  }
  return out;
}

Image8 depth_picture(const ImageF& zdepth) {
  Image8 out(zdepth.width(), zdepth.height(), 3);
  std::vector<float> valid;
  for (float z : zdepth.data())
    if (z > 0) valid.push_back(z);
  if (valid.empty()) return out;
  const double low = quantile_of(valid, kDepthLow), high = quantile_of(valid, kDepthHigh);
  for (size_t i = 0; i < zdepth.pixel_count(); ++i) {
    const double z = zdepth.data()[i];
    if (!(z > 0)) continue;
    const double t = high > low ? (1 / low - 1 / z) / (1 / low - 1 / high) : 0;
    paint_ramp(0.95 - 0.85 * std::clamp(t, 0.0, 1.0), &out.data()[3 * i]);
  }
  return out;
}

Image8 contact_sheet(std::span<const SheetRow> rows, int cell_width) {
  constexpr size_t kColumns = 5;
  if (rows.empty() || rows[0].cells.empty()) return Image8(1, 1, 3);
  const Image8& first = rows[0].cells[0].picture;
  const int width = std::min(cell_width, first.width());
  const int height = std::max(1, int(std::lround(double(first.height()) * width / first.width())));
  const int bar = kGlyphHeight * kTextScale + 2 * kMargin;
  const auto lines = [](const SheetRow& row) { return int((row.cells.size() + kColumns - 1) / kColumns); };
  int total = 0;
  for (const SheetRow& row : rows) total += lines(row) * (bar + height) + bar;
  Image8 sheet(int(kColumns) * (width + kGap) + kGap, total, 3, uint8_t(24));
  int y = 0;
  for (const SheetRow& row : rows) {
    for (size_t i = 0; i < row.cells.size(); ++i) {
      const int x = kGap + int(i % kColumns) * (width + kGap), top = y + int(i / kColumns) * (bar + height);
      draw_text(sheet, x, top + kMargin, row.cells[i].title, kTextScale, 200);
      paste(row.cells[i].picture, x, top + bar, width, height, sheet);
    }
    y += lines(row) * (bar + height);
    draw_text(sheet, kGap, y + kMargin, row.label, kTextScale, 255);
    y += bar;
  }
  return sheet;
}

}  // namespace vitrine
