#include "stages/normals/normal_map.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

// Image edges and the rounding of 8-bit files tilt normals slightly beyond the silhouette.
constexpr float kGrazing = 0.1f;
// Minimum length of the mean of two mixed normals; below it the mean is unreliable.
constexpr float kShortestMean = 0.3f;
constexpr float kShortestStored = 0.7f, kLongestStored = 1.3f;  // of a stored normal; blending and rounding change its length
constexpr double kMostNormals = 0.8;                            // minimum share of pixels with such a length in a normal map

struct Decoded {
  ImageF normal;  // as stored, not yet of unit length; 0 0 0 = unknown
  double share = 0;
};

// Decodes (n + 1) / 2 in [0,1]; black or alpha 0 conventionally means no normal.
Decoded decoded(const ImageF& file, bool encoded) {
  Decoded d{ImageF(file.width(), file.height(), 3)};
  size_t known = 0, normal = 0;
  for (size_t i = 0; i < file.pixel_count(); ++i) {
    const float* p = file.data().data() + i * size_t(file.channels());
    const bool hidden = file.channels() > 3 && p[3] < 0.5f;
    if (hidden || (p[0] == 0 && p[1] == 0 && p[2] == 0)) continue;
    Vec3f n{p[0], p[1], p[2]};
    if (encoded) n = 2.f * n - Vec3f{1, 1, 1};
    ++known;
    const float size = length(n);
    if (!(size >= kShortestStored && size <= kLongestStored)) continue;
    ++normal;
    for (size_t c = 0; c < 3; ++c) d.normal.data()[3 * i + c] = n[c] / size;
  }
  d.share = known > 0 ? double(normal) / double(known) : 0;
  return d;
}

[[noreturn]] void refuse(const fs::path& file, std::string why) {
  throw Error(ErrorKind::Input, "this is not a normal map",
              {.where = file.string(),
               .why = std::move(why),
               .hint = "PNG of 8 or 16 bit with rgb = (n + 1) / 2, or EXR with the channels X Y Z; black = unknown",
               .code = "NOT_A_NORMAL_MAP"});
}

ImageF pixels_of(const fs::path& file) {
  if (file.extension() == ".exr") {
    ExrImage exr = read_exr(file);
    if (exr.pixels.channels() != 3 && exr.pixels.channels() != 4)
      refuse(file, fmt::format("it has {} channels: {}", exr.pixels.channels(), fmt::join(exr.channels, " ")));
    return std::move(exr.pixels);
  }
  ImageF image = read_unchanged(file);
  if (image.channels() < 3) refuse(file, "it has a single channel");
  return image;
}

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

std::optional<fs::path> find_normal_file(const fs::path& folder, const View& view) {
  const std::string bare = fs::path(view.stem()).filename().generic_string();
  for (const std::string& stem : {view.stem(), bare})
    for (const char* suffix : {"", "_normal", "_normals"})
      for (const char* extension : {".exr", ".png"})
        if (const fs::path path = folder / (stem + suffix + extension); fs::exists(path)) return path;
  for (const char* extension : {".exr", ".png"})
    if (const fs::path path = folder / (view.name + extension); fs::exists(path)) return path;
  return std::nullopt;
}

NormalMap read_normal_file(const fs::path& file, const View& view) {
  const ImageF pixels = pixels_of(file);
  const Intrinsics& k = view.intrinsics;
  // Same aspect ratio as the photo, to within the rounding of a pixel.
  if (std::abs(double(pixels.width()) * k.height - double(pixels.height()) * k.width) > k.longest_side())
    throw Error(ErrorKind::Input, "a normal map does not have its photo's shape",
                {.where = file.string(),
                 .why = fmt::format("{} x {} pixels; the undistorted photo has {} x {}", pixels.width(), pixels.height(), k.width,
                                    k.height),
                 .hint = "predict the normals of the photos in images/ of the output folder, which are undistorted",
                 .code = "SIZE_MISMATCH"});
  const bool exr = file.extension() == ".exr";
  Decoded d = decoded(pixels, !exr);
  if (exr && d.share < kMostNormals)  // some tools write (n + 1) / 2 to EXR as well
    if (Decoded other = decoded(pixels, true); other.share > d.share) d = std::move(other);
  if (d.share < kMostNormals)
    refuse(file, d.share == 0 ? "no pixel holds a vector of unit length"
                              : fmt::format("only {:.0f} % of its pixels are vectors of unit length", 100 * d.share));
  NormalMap map(pixels.width(), pixels.height());
  map.normal = std::move(d.normal);
  ImageF given;
  const fs::path confidence_file = file.parent_path() / (file.stem().string() + "_confidence.png");
  if (fs::exists(confidence_file)) given = resized(read_unchanged(confidence_file), pixels.width(), pixels.height());
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x)
      if (squared_length(map.at(x, y)) > 0) map.confidence.at(x, y) = given.empty() ? 1.f : given.at(x, y);
  return map;
}

}  // namespace vitrine
