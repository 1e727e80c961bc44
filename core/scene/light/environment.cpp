#include "core/scene/light/environment.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/scene/image/color_profile.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/file_kind.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/probe.h"
#include "core/scene/image/tiff_pages.h"

namespace vitrine {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;
// Minimum sampling density relative to the mean luminance, so that every direction has a non-zero pdf.
constexpr double kLeastDensity_rel = 1e-3;

double luminance(const float* rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

// Inverse CDF: interval of a table that rises from 0 to 1, and the position in it.
std::pair<int, float> found(const float* cdf, int n, float u) {
  const int i = std::clamp(static_cast<int>(std::upper_bound(cdf, cdf + n + 1, u) - cdf) - 1, 0, n - 1);
  const float width = cdf[i + 1] - cdf[i];
  return {i, width > 0 ? std::clamp((u - cdf[i]) / width, 0.f, 1.f) : 0.5f};
}

struct Texel {
  int x, y;
};
Texel texel_of(const Vec2f& uv, int width, int height) {
  return {std::min(static_cast<int>(uv.x * static_cast<float>(width)), width - 1),
          std::min(static_cast<int>(uv.y * static_cast<float>(height)), height - 1)};
}

}  // namespace

double texel_solid_angle(int y, int width, int height) {
  const double top = std::cos(std::numbers::pi * y / height), bottom = std::cos(std::numbers::pi * (y + 1) / height);
  return 2 * std::numbers::pi / width * (top - bottom);
}

Vec3f lat_long_direction(float u, float v) {
  const float azimuth = -2.f * kPi * (u - 0.5f), elevation = kPi * (0.5f - v), c = std::cos(elevation);
  return {c * std::cos(azimuth), c * std::sin(azimuth), std::sin(elevation)};
}

Vec2f lat_long_coordinates(const Vec3f& d) {
  const float u = 0.5f - std::atan2(d.y, d.x) / (2.f * kPi);
  return {u < 1.f ? std::max(u, 0.f) : 0.f, 0.5f - std::asin(std::clamp(d.z, -1.f, 1.f)) / kPi};
}

Environment::Environment(ImageF rgb, const Mat3f& world_from_map) : map_(std::move(rgb)), world_from_map_(world_from_map) {
  const int w = map_.width(), h = map_.height();
  VITRINE_CHECK(map_.channels() == 3 && w == 2 * h && h > 0, "an environment of {}x{}x{}", w, h, map_.channels());
  density_.resize(map_.pixel_count());
  // Mean of a bilinear lookup over a texel: weights 1/8, 3/4, 1/8 in each direction.
  constexpr double kTent[3] = {0.125, 0.75, 0.125};
  double sum = 0;
  Vec3d mean{};
  for (int y = 0; y < h; ++y) {
    const double solid_angle = texel_solid_angle(y, w, h);
    for (int x = 0; x < w; ++x) {
      double l = 0;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
          l += kTent[i + 1] * kTent[j + 1] * luminance(map_.pixel((x + i + w) % w, std::clamp(y + j, 0, h - 1)));
      density_[size_t(y) * size_t(w) + size_t(x)] = static_cast<float>(l);
      sum += l * solid_angle;
      for (size_t c = 0; c < 3; ++c) mean[c] += map_.at(x, y, int(c)) * solid_angle;
    }
  }
  mean_ = cast<float>(mean / (4 * std::numbers::pi));
  if (!(sum > 0)) return;
  const float least = static_cast<float>(kLeastDensity_rel * sum / (4 * std::numbers::pi));
  row_cdf_.assign(size_t(h) + 1, 0.f);
  texel_cdf_.assign(size_t(h) * (size_t(w) + 1), 0.f);
  std::vector<double> rows(size_t(h) + 1, 0.0), texels(size_t(w) + 1, 0.0);
  for (int y = 0; y < h; ++y) {
    float* row_density = &density_[size_t(y) * size_t(w)];
    for (size_t x = 0; x < size_t(w); ++x) {
      row_density[x] = std::max(row_density[x], least);
      texels[x + 1] = texels[x] + row_density[x];
    }
    float* cdf = &texel_cdf_[size_t(y) * (size_t(w) + 1)];
    for (size_t x = 0; x <= size_t(w); ++x) cdf[x] = static_cast<float>(texels[x] / texels.back());
    rows[size_t(y) + 1] = rows[size_t(y)] + texels.back() * texel_solid_angle(y, w, h);
  }
  total_ = rows.back();
  for (size_t y = 0; y <= size_t(h); ++y) row_cdf_[y] = static_cast<float>(rows[y] / total_);
}

Vec3f Environment::radiance(const Vec3f& direction) const {
  if (map_.empty()) return {};
  const int w = map_.width(), h = map_.height();
  const Vec2f uv = lat_long_coordinates(transposed_times(world_from_map_, direction));
  const float fx = uv.x * static_cast<float>(w) - 0.5f, fy = uv.y * static_cast<float>(h) - 0.5f;
  const float floor_x = std::floor(fx), floor_y = std::floor(fy), tx = fx - floor_x, ty = fy - floor_y;
  const int x0 = floor_x < 0 ? w - 1 : static_cast<int>(floor_x), x1 = x0 + 1 == w ? 0 : x0 + 1;  // wraps around
  const int y0 = std::max(static_cast<int>(floor_y), 0), y1 = std::min(static_cast<int>(floor_y) + 1, h - 1);
  const float *a = map_.pixel(x0, y0), *b = map_.pixel(x1, y0), *c = map_.pixel(x0, y1), *d = map_.pixel(x1, y1);
  Vec3f out;
  for (size_t i = 0; i < 3; ++i) out[i] = (1 - ty) * ((1 - tx) * a[i] + tx * b[i]) + ty * ((1 - tx) * c[i] + tx * d[i]);
  return out;
}

Vec3f Environment::irradiance(const Vec3f& normal) const {
  const int w = map_.width(), h = map_.height();
  const Vec3f n = transposed_times(world_from_map_, normal);
  Vec3d sum{};
  for (int y = 0; y < h; ++y) {
    const double solid_angle = texel_solid_angle(y, w, h);
    for (int x = 0; x < w; ++x) {
      const Vec3f d = lat_long_direction((float(x) + 0.5f) / float(w), (float(y) + 0.5f) / float(h));
      const double weight = solid_angle * double(std::max(0.f, dot(n, d)));
      const float* p = map_.pixel(x, y);
      for (size_t c = 0; c < 3; ++c) sum[c] += weight * double(p[c]);
    }
  }
  return cast<float>(sum);
}

Environment::Sample Environment::sample(const Vec2f& uniform) const {
  if (black()) return {};
  const int w = map_.width(), h = map_.height();
  const auto [y, ty] = found(row_cdf_.data(), h, uniform.y);
  const auto [x, tx] = found(&texel_cdf_[size_t(y) * (size_t(w) + 1)], w, uniform.x);
  // Uniform over the solid angle: uniform in azimuth and z.
  const float azimuth = -2.f * kPi * ((static_cast<float>(x) + tx) / static_cast<float>(w) - 0.5f);
  const float top = std::cos(kPi * static_cast<float>(y) / static_cast<float>(h));
  const float bottom = std::cos(kPi * static_cast<float>(y + 1) / static_cast<float>(h));
  const float z = top + ty * (bottom - top), s = std::sqrt(std::max(1.f - z * z, 0.f));
  const Vec3f direction = world_from_map_ * Vec3f{s * std::cos(azimuth), s * std::sin(azimuth), z};
  return {direction, radiance(direction), static_cast<float>(density_[size_t(y) * size_t(w) + size_t(x)] / total_)};
}

float Environment::pdf(const Vec3f& direction) const {
  if (black()) return 0;
  const int w = map_.width(), h = map_.height();
  const Texel t = texel_of(lat_long_coordinates(transposed_times(world_from_map_, direction)), w, h);
  return static_cast<float>(density_[size_t(t.y) * size_t(w) + size_t(t.x)] / total_);
}

Environment Environment::turned(const Mat3f& rotation) const {
  Environment out = *this;
  out.world_from_map_ = rotation * world_from_map_;
  return out;
}

Environment Environment::rotated(double degrees) const {
  const double turn = std::fmod(degrees, 360.0);
  if (turn == 0) return *this;
  const double a = turn * std::numbers::pi / 180;
  const float c = static_cast<float>(std::cos(a)), s = static_cast<float>(std::sin(a));
  return turned({{c, s, 0}, {-s, c, 0}, {0, 0, 1}});
}

namespace {

// Detects the format by the first bytes, not by the file name.
ImageF read_texels(const fs::path& path, std::vector<std::string>& notes) {
  constexpr std::string_view kHint = "give a lat-long map as OpenEXR (.exr) or Radiance HDR (.hdr)";
  std::error_code ec;
  if (!fs::is_regular_file(path, ec))
    throw Error(ErrorKind::Input, "there is no such environment map",
                {.where = path.string(), .hint = std::string(kHint), .code = "MISSING_INPUT"});
  const std::string bytes = read_file(path);
  const std::string_view start(bytes);
  if (start.starts_with("\x76\x2f\x31\x01")) {
    ExrPicture picture = read_exr_picture(path);
    notes = std::move(picture.notes);
    return std::move(picture.rgb);
  }
  if (start.starts_with("#?")) return parse_radiance_hdr(bytes, path.string(), &notes);
  if (is_tiff(start) && probe_photo(bytes).float_samples) {
    notes.emplace_back("a TIFF of floating-point samples, taken as linear");
    return read_srgb(path);
  }
  constexpr std::string_view kLdr[] = {"\x89PNG", "\xff\xd8\xff", "GIF8", "BM"};
  const bool ldr = is_tiff(start) ||
                   std::ranges::any_of(kLdr, [&](std::string_view magic) { return start.starts_with(magic); }) ||
                   (start.starts_with("RIFF") && start.substr(0, 12).ends_with("WEBP"));
  if (ldr)
    throw Error(ErrorKind::Input, "this picture cannot be an environment map",
                {.where = path.string(),
                 .why = "it is a display picture: its lamps and its sun are clipped to white, so that they would light nothing",
                 .hint = std::string(kHint),
                 .code = "ENV_LDR"});
  const std::string kind = bytes.empty() ? "an empty file" : file_kind(bytes).name;
  throw Error(ErrorKind::Input, "this file is not an environment map",
              {.where = path.string(),
               .why = fmt::format("it is neither OpenEXR nor Radiance HDR{}{}", kind.empty() ? "" : " but ", kind),
               .hint = std::string(kHint),
               .code = "ENV_FORMAT"});
}

void check_texels(const ImageF& map, const fs::path& path) {
  if (map.width() != 2 * map.height())
    throw Error(
        ErrorKind::Input, "an environment map must be twice as wide as high",
        {.where = path.string(),
         .why = fmt::format("it is {} x {}", map.width(), map.height()),
         .hint = "a lat-long (equirectangular) map of the whole sphere is wanted; convert cube maps and light probes first",
         .code = "ENV_SHAPE"});
  size_t nan = 0, infinite = 0, first = map.pixel_count();
  for (size_t i = 0; i < map.pixel_count(); ++i) {
    const float* p = &map.data()[3 * i];
    const bool is_nan = std::isnan(p[0]) || std::isnan(p[1]) || std::isnan(p[2]);
    const bool is_infinite = !is_nan && (std::isinf(p[0]) || std::isinf(p[1]) || std::isinf(p[2]));
    nan += is_nan, infinite += is_infinite;
    if ((is_nan || is_infinite) && first == map.pixel_count()) first = i;
  }
  if (first == map.pixel_count()) return;
  const size_t w = size_t(map.width());
  throw Error(ErrorKind::Input, "an environment map has texels that are no light",
              {.where = path.string(),
               .why = fmt::format("{} NaN, {} infinite; the first in column {}, row {}", nan, infinite, first % w, first / w),
               .hint = "repair it, for example: oiiotool IN --fixnan box3 --clamp:min=0:max=60000 -o OUT.exr",
               .code = "ENV_BAD_TEXELS"});
}

// Renderers that work in ACEScg store their primaries in the EXR header.
void to_rec709(ImageF& map, const fs::path& path) {
  constexpr size_t kHeader = 1 << 16;
  std::string head(kHeader, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(in.gcount()));
  if (!head.starts_with("\x76\x2f\x31\x01")) return;
  const ExrPrimaries colors = exr_primaries(head);
  if (!colors.problem.empty()) log_warning("environment map {}: {}; taken as Rec. 709", path.filename().string(), colors.problem);
  if (colors.profile->has_rec709_primaries()) return;
  log_info("environment map {}: {} -> linear Rec. 709", path.filename().string(), colors.profile->name());
  colors.profile->float_to_linear(map);
}

size_t clamp_negative(ImageF& map) {
  size_t texels = 0;
  for (size_t i = 0; i < map.pixel_count(); ++i) {
    float* p = &map.data()[3 * i];
    texels += std::min({p[0], p[1], p[2]}) < 0;
    for (size_t c = 0; c < 3; ++c) p[c] = std::max(p[c], 0.f);
  }
  return texels;
}

}  // namespace

Environment read_environment(const fs::path& path, size_t* negative) {
  std::vector<std::string> notes;
  ImageF map = read_texels(path, notes);
  for (const std::string& note : notes) log_info("environment map {}: {}", path.filename().string(), note);
  check_texels(map, path);
  to_rec709(map, path);
  const size_t texels = clamp_negative(map);
  if (negative != nullptr) *negative = texels;
  return Environment(std::move(map));
}

void write_environment(const fs::path& path, const Environment& environment) {
  VITRINE_CHECK(environment.world_from_map() == Mat3f::identity(), "a turned environment is not written");
  write_exr_rgb(path, environment.map(), ExrPrecision::Float,
                {{"vitrine:lat_long", "first row +z, centre +x, three quarters -y"}});
}

Environment axis_probe(int width) {
  const int height = width / 2;
  ImageF map(width, height, 3, 0.05f);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vec3f d = lat_long_direction((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                         (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
      for (size_t axis = 0; axis < 3; ++axis) {
        if (!(std::abs(d[axis]) > 0.95f)) continue;
        for (size_t c = 0; c < 3; ++c) map.at(x, y, int(c)) = (c == axis) == (d[axis] > 0) ? 1.f : 0.f;
      }
    }
  return Environment(std::move(map));
}

}  // namespace vitrine
