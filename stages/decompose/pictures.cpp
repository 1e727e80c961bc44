#include "stages/decompose/pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/camera/view_set.h"
#include "core/image/bitmap_font.h"
#include "core/image/exr.h"
#include "core/image/ldr.h"
#include "core/image/resample.h"
#include "core/math/color.h"
#include "core/math/median.h"
#include "core/picture/surfel_colors.h"

namespace vitrine {

namespace {

constexpr int kGap = 4, kTitle = 12;
constexpr float kTooDark = 0.004f;  // photos below say nothing about ratios
constexpr float kRatioSpan = 2;     // doublings from grey to white or black

// Rows of equal pictures with a line of text above each.
Image8 sheet(const std::vector<std::vector<Image8>>& rows, const std::vector<std::string>& labels) {
  int width = 0, height = kGap;
  for (const auto& row : rows) {
    width = std::max(width, kGap + int(row.size()) * (row[0].width() + kGap));
    height += kTitle + row[0].height() + kGap;
  }
  Image8 out(width, height, 3, uint8_t(24));
  int top = kGap;
  for (size_t r = 0; r < rows.size(); ++r) {
    draw_text(out, kGap, top + 2, labels[r]);
    int left = kGap;
    for (const Image8& picture : rows[r]) {
      for (int y = 0; y < picture.height(); ++y)
        std::copy_n(picture.pixel(0, y), 3 * size_t(picture.width()), out.pixel(left, top + kTitle + y));
      left += picture.width() + kGap;
    }
    top += kTitle + rows[r][0].height() + kGap;
  }
  return out;
}

// Tone of the light: its own median becomes middle grey, whatever its unit.
ImageF exposed(ImageF picture) {
  std::vector<float> values;
  for (const float v : picture.data())
    if (v > 0) values.push_back(v);
  if (values.empty()) return picture;
  const float gain = 0.25f / upper_median_of(std::span(values));
  for (float& v : picture.data()) v *= gain;
  return picture;
}

}  // namespace

std::optional<double> write_decompose_pictures(const DecomposePicturesDesc& desc) {
  SurfelColors albedo(desc.layer, desc.albedo, desc.near_z), irradiance(desc.layer, desc.irradiance, desc.near_z);
  std::vector<std::vector<Image8>> albedo_rows, baked_rows;
  std::vector<std::string> albedo_labels, baked_labels;
  double squares = 0, count = 0;
  const size_t rows = std::min(desc.views.size(), size_t(desc.rows));
  for (size_t r = 0; r < rows; ++r) {
    View view = desc.views[r * desc.views.size() / rows];
    view.intrinsics = view.intrinsics.limited_to(desc.cell_width);
    const int w = view.intrinsics.width, h = view.intrinsics.height;
    ImageF photo = resized(read_exr_rgb(linear_image_path(desc.sfm_folder, view)), w, h);
    for (size_t i = 0; i < photo.pixel_count(); ++i)
      for (size_t c = 0; c < 3; ++c) photo.data()[3 * i + c] /= float(view.gain[c]);
    const ImageF rho = albedo.picture(view), light = irradiance.picture(view);
    ImageF ratio(w, h, 3), product(w, h, 3);
    for (size_t i = 0; i < ratio.data().size(); ++i) {
      product.data()[i] = rho.data()[i] * light.data()[i] / std::numbers::pi_v<float>;
      if (!(product.data()[i] > kTooDark) || !(photo.data()[i] > kTooDark)) continue;
      const float doublings = std::log2(photo.data()[i] / product.data()[i]);
      squares += double(doublings) * doublings;
      count += 1;
      ratio.data()[i] = linear_from_srgb(std::clamp(0.5f + doublings / (2 * kRatioSpan), 0.f, 1.f));
    }
    albedo_rows.push_back({srgb8_from_linear(photo), srgb8_from_linear(rho), srgb8_from_linear(exposed(light))});
    albedo_labels.push_back(fmt::format("{}   PHOTO, ALBEDO, LIGHT ON THE SURFACE", view.stem()));
    baked_rows.push_back({srgb8_from_linear(photo), srgb8_from_linear(product), srgb8_from_linear(ratio)});
    baked_labels.push_back(fmt::format("{}   PHOTO, ALBEDO X LIGHT, THEIR RATIO (GREY 1, WHITE X4)", view.stem()));
  }
  if (rows > 0) {
    write_ldr(desc.output / "decompose" / "albedo.png", sheet(albedo_rows, albedo_labels));
    write_ldr(desc.output / "decompose" / "baked.png", sheet(baked_rows, baked_labels));
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(squares / count) * std::numbers::ln2;
}

}  // namespace vitrine
