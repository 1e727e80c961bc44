#include "stages/decompose/outputs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/scene/camera/view_set.h"
#include "core/scene/image/contact_sheet.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/median.h"
#include "core/render/picture/surfel_colors.h"

namespace vitrine {

namespace {

constexpr int kSheetCell = 320;     // width of a picture, pixels
constexpr float kTooDark = 0.004f;  // darker photo values give unreliable ratios
constexpr float kRatioSpan = 2;     // stops from grey to white or black

// Exposure: maps the median of the picture to middle grey.
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
  ContactSheet albedo_sheet(3, kSheetCell), baked_sheet(3, kSheetCell);
  double squares = 0, count = 0;
  const size_t rows = std::min(desc.views.size(), size_t(desc.rows));
  for (size_t r = 0; r < rows; ++r) {
    View view = desc.views[r * desc.views.size() / rows];
    view.intrinsics = view.intrinsics.limited_to(kSheetCell);
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
    albedo_sheet.start_row(view.stem());
    albedo_sheet.add("PHOTO", srgb8_from_linear(photo));
    albedo_sheet.add("ALBEDO", srgb8_from_linear(rho));
    albedo_sheet.add("LIGHT ON THE SURFACE", srgb8_from_linear(exposed(light)));
    baked_sheet.start_row(view.stem());
    baked_sheet.add("PHOTO", srgb8_from_linear(photo));
    baked_sheet.add("ALBEDO X LIGHT", srgb8_from_linear(product));
    baked_sheet.add("RATIO: GREY 1, WHITE X4", srgb8_from_linear(ratio));
  }
  albedo_sheet.write(desc.output / "decompose" / "albedo.png");
  baked_sheet.write(desc.output / "decompose" / "baked.png");
  if (count == 0) return std::nullopt;
  return std::sqrt(squares / count) * std::numbers::ln2;
}

nlohmann::ordered_json report_of(const FoundLight& f) {
  using Json = nlohmann::ordered_json;
  const LightSolution& solution = f.solution;
  const bool card = !f.config.grey_card.empty();
  Json report{
      {"points",
       {{"all", f.points.size()},
        {"on_mesh", std::ranges::count(f.points, true, &LitPoint::inner)},
        {"usable", std::ranges::count(f.usable, true)},
        {"solved_with", f.solved_with},
        {"voxel", f.voxel}}},
      {"cells", {{"all", solution.light.size()}, {"solved", std::ranges::count(solution.free, true)}}},
      {"surroundings",
       {{"share_of_sphere", f.around.wall_share()},
        {"faces", f.shell_faces},
        {"sky_distance", f.sky_distance},
        {"continued_to_sine", f.walls.sine},
        {"mirrored_sky_from_sine", f.horizon ? Json(*f.horizon) : Json()}}},
      {"light_known_share", solution.known_share},
      {"misfit_log_rms", solution.misfit},
      {"scale",
       {{"by", card ? "grey_card" : "convention"},
        {"meaning", card ? fmt::format("the card has the albedo {}", f.config.grey_albedo)
                         : fmt::format("the open light is white in the mean, and the brightest twentieth of the surface has the "
                                       "albedo {}",
                                       f.config.white_albedo)},
        {"limited_by_bounced_light", solution.scale_by_bounces}}}};
  if (f.card_outside_scene) report["scale"]["card"] = "in the photo, beside the trained scene";
  return report;
}

}  // namespace vitrine
