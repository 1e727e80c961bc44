#include "stages/normals/normal_map.h"

#include <algorithm>
#include <cmath>

#include "core/base/file.h"
#include "core/image/exr.h"
#include "core/image/ldr.h"
#include "core/image/resample.h"

namespace vitrine {

namespace {

// Edges and the rounding of 8-bit files tilt a normal a little beyond the silhouette.
constexpr float kGrazing = 0.1f;
// Two normals that a pixel mixes half and half: below this length of their mean they say nothing.
constexpr float kShortestMean = 0.3f;

}  // namespace

NormalMap resized(const NormalMap& map, int width, int height) {
  if (map.normal.width() == width && map.normal.height() == height) return map;
  ImageF weighted(map.normal.width(), map.normal.height(), 4);
  for (int y = 0; y < weighted.height(); ++y)
    for (int x = 0; x < weighted.width(); ++x) {
      const float c = map.confidence.at(x, y);
      for (int i = 0; i < 3; ++i) weighted.at(x, y, i) = c * map.normal.at(x, y, i);
      weighted.at(x, y, 3) = c;
    }
  const ImageF small = resized(weighted, width, height);
  NormalMap out(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float* p = small.pixel(x, y);
      const Vec3f sum{p[0], p[1], p[2]};
      const float agreement = p[3] > 0 ? length(sum) / p[3] : 0;
      if (agreement > kShortestMean) out.set(x, y, normalized(sum), std::min(1.f, p[3] * agreement));
    }
  return out;
}

Facing forget_hidden_sides(NormalMap& map, const Intrinsics& k) {
  Facing facing;
  for (int y = 0; y < map.normal.height(); ++y)
    for (int x = 0; x < map.normal.width(); ++x) {
      const Vec3f n = map.at(x, y);
      if (squared_length(n) == 0) continue;
      ++facing.known;
      if (dot(n, cast<float>(normalized(k.ray(x + 0.5, y + 0.5)))) <= kGrazing) continue;
      ++facing.away;
      map.forget(x, y);
    }
  return facing;
}

void write_normal_map(const std::filesystem::path& folder, const View& view, const NormalMap& map) {
  const fs::path exr = folder / (view.stem() + ".exr");
  make_folders(exr.parent_path());
  write_exr(exr, {.pixels = map.normal, .channels = {"X", "Y", "Z"}, .attributes = {{"vitrine:frame", "camera-opencv"}}});
  Image8 grey(map.confidence.width(), map.confidence.height(), 1);
  for (size_t i = 0; i < grey.data().size(); ++i)
    grey.data()[i] = static_cast<uint8_t>(std::lround(255 * std::clamp(map.confidence.data()[i], 0.f, 1.f)));
  write_ldr(folder / (view.stem() + "_confidence.png"), grey);
}

}  // namespace vitrine
