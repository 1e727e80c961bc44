// vitrine-strip FOLDER VIEW RELIT.png OUT.jpg: four pictures of one view side by side, 480 pixels wide each: the photo, the
// rendered view, the view without its glass, the view under another light. FOLDER is a run whose view was rendered with --layers
// and relit (strip.sh). Without its glass: the transmitted radiance replaces the radiance where the transmission weight tau is
// above a half, and part of it from a tenth on; linear light, at a gain of 1.
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/image.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace {

using namespace vitrine;

ImageF without_glass(const fs::path& layers, const std::string& view) {
  const std::string file = view + ".exr";
  ImageF radiance = read_exr_rgb(layers / "radiance" / file);
  const ImageF transmitted = read_exr_rgb(layers / "transmitted" / file);
  const ImageF weight = read_exr(layers / "transmission_weight" / file).pixels;
  for (int y = 0; y < radiance.height(); ++y)
    for (int x = 0; x < radiance.width(); ++x) {
      const float share = std::clamp((weight.at(x, y) - 0.1f) / 0.4f, 0.f, 1.f);
      for (int c = 0; c < 3; ++c) radiance.at(x, y, c) = std::lerp(radiance.at(x, y, c), transmitted.at(x, y, c), share);
    }
  return radiance;
}

fs::path photo(const fs::path& run, const std::string& view) {
  for (const auto& e : fs::directory_iterator(run / "images"))
    if (e.path().stem() == view) return e.path();
  return run / "images" / (view + ".jpg");
}

ImageF side_by_side(const std::array<ImageF, 4>& linear) {
  constexpr int kSide = 480, kGap = 4;
  const int height = static_cast<int>(std::lround(double(kSide) * linear[0].height() / linear[0].width()));
  ImageF out(4 * kSide + 3 * kGap, height, 3, 1.f);
  for (size_t i = 0; i < linear.size(); ++i) {
    const ImageF tile = resized(linear[i], kSide, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < kSide; ++x)
        for (int c = 0; c < 3; ++c) out.at(int(i) * (kSide + kGap) + x, y, c) = tile.at(x, y, c);
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::cerr << "usage: vitrine-strip FOLDER VIEW RELIT.png OUT.jpg\n";
    return 2;
  }
  const fs::path run = argv[1];
  const std::string view = argv[2];
  try {
    const std::array<ImageF, 4> linear{linear_from_srgb_image(read_srgb(photo(run, view))),
                                       linear_from_srgb_image(read_srgb(run / "render" / (view + ".png"))),
                                       without_glass(run / "render/layers", view), linear_from_srgb_image(read_srgb(argv[3]))};
    write_ldr(argv[4], srgb8_from_linear(side_by_side(linear)), 85);
  } catch (const std::exception& e) {
    std::cerr << "error: " << e.what() << "\n";
    return 1;
  }
}
