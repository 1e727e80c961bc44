#include "stages/evaluate/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/foundation/base/file.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {

constexpr double kErrorWhite = 0.25;                   // sRGB difference shown as white
constexpr double kDepthLow = 0.02, kDepthHigh = 0.98;  // quantiles: nearest, farthest
// Colour ramp of increasing luminance, readable in grey too.
constexpr std::array<std::array<double, 3>, 6> kRamp{
    {{0, 0, 0}, {0.22, 0.05, 0.42}, {0.62, 0.13, 0.45}, {0.93, 0.38, 0.22}, {0.99, 0.76, 0.22}, {1, 1, 0.92}}};

uint8_t byte_of(double v) { return uint8_t(std::lround(std::clamp(v, 0.0, 1.0) * 255)); }

void paint_ramp(std::span<const std::array<double, 3>> ramp, double t, uint8_t* rgb) {
  const double position = std::clamp(t, 0.0, 1.0) * double(ramp.size() - 1);
  const size_t i = std::min(size_t(position), ramp.size() - 2);
  const double f = position - double(i);
  for (size_t c = 0; c < 3; ++c) rgb[c] = byte_of((1 - f) * ramp[i][c] + f * ramp[i + 1][c]);
}

struct LayerCell {
  std::string_view layer, title;
  bool radiance;
};
constexpr std::array<LayerCell, 9> kCells{{{"diffuse", "DIFFUSE", true},
                                           {"reflection", "REFLECTION", true},
                                           {"transmission", "TRANSMISSION", true},
                                           {"reflected", "REFLECTED", true},
                                           {"transmitted", "TRANSMITTED", true},
                                           {"fresnel", "FRESNEL", false},
                                           {"specular_weight", "K-S", false},
                                           {"transmission_weight", "TAU", false},
                                           {"roughness", "ROUGHNESS", false}}};

Image8 radiance_picture(const ImageF& linear, const Vec3d& gain) {
  ImageF scaled = linear;
  for (size_t i = 0; i < scaled.data().size(); ++i) scaled.data()[i] *= float(gain[i % 3]);
  return srgb8_from_linear(scaled);
}

}  // namespace

Image8 error_picture(const ImageF& srgb, const ImageF& photo) {
  Image8 out(srgb.width(), srgb.height(), 3);
  for (size_t i = 0; i < srgb.pixel_count(); ++i) {
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) sum += std::abs(double(srgb.data()[3 * i + c]) - photo.data()[3 * i + c]);
    paint_ramp(kRamp, sum / 3 / kErrorWhite, &out.data()[3 * i]);
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
    paint_ramp(kRamp, 0.95 - 0.85 * std::clamp(t, 0.0, 1.0), &out.data()[3 * i]);
  }
  return out;
}

void add_view(const ViewPicture& picture, const ImageF& photo, const std::optional<Vec3d>& gain, ContactSheet& sheet) {
  sheet.add("PHOTO", bytes_of(photo));
  sheet.add("RENDER", bytes_of(picture.srgb));
  sheet.add("ERROR", error_picture(picture.srgb, photo));
  sheet.add("NORMALS", normal_picture(picture.normal_in_world));
  sheet.add("DEPTH", depth_picture(picture.zdepth));
  if (!gain) return;
  for (const LayerCell& cell : kCells)
    if (const ImageF* map = picture.layer(cell.layer))
      sheet.add(std::string(cell.title), cell.radiance ? radiance_picture(*map, *gain) : bytes_of(*map));
}

void write_clear(const std::filesystem::path& eval_folder, const View& view, const ImageF& clear) {
  write_ldr((eval_folder / view.stem()).string() + "_clear.png", radiance_picture(clear, view.gain));
}

void write_pictures(const std::filesystem::path& eval_folder, const View& view, const ImageF& srgb, const ImageF& photo) {
  const std::filesystem::path base = eval_folder / view.stem();
  make_folders(base.parent_path());
  write_ldr(base.string() + "_gt.png", bytes_of(photo));
  write_ldr(base.string() + "_pred.png", bytes_of(srgb));
  write_ldr(base.string() + "_err.png", error_picture(srgb, photo));
}

void write_confidence(const std::filesystem::path& eval_folder, const View& view, const ImageF& confidence) {
  constexpr std::array<std::array<double, 3>, 5> kViridis{
      {{0.27, 0, 0.33}, {0.23, 0.32, 0.55}, {0.13, 0.57, 0.55}, {0.37, 0.79, 0.38}, {0.99, 0.91, 0.15}}};
  Image8 out(confidence.width(), confidence.height(), 3);
  for (size_t i = 0; i < confidence.pixel_count(); ++i)
    if (confidence.data()[i] > 0) paint_ramp(kViridis, confidence.data()[i], &out.data()[3 * i]);
  const std::filesystem::path base = eval_folder / view.stem();
  make_folders(base.parent_path());
  write_ldr(base.string() + "_conf.png", out);
}

void write_layers(const std::filesystem::path& eval_folder, const View& view, const ViewPicture& picture) {
  for (const PictureLayer& layer : picture.layers) {
    const std::filesystem::path path = eval_folder / "layers" / layer.name / (view.stem() + ".exr");
    make_folders(path.parent_path());
    write_exr(path, layer.map);
  }
}

}  // namespace vitrine
