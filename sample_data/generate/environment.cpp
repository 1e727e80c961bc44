#include "sample_data/generate/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Imath/half.h>

#include "core/foundation/base/parallel.h"
#include "sample_data/generate/texture.h"

namespace vitrine::generate {
namespace {

// Keeps every texel reachable, so that the estimate stays unbiased when the weights are only a guess.
constexpr float kLeastShare = 0.1f;

Vec3f direction_at(float u, float v) {
  const float azimuth = -2.0f * kPi * (u - 0.5f), elevation = kPi * (0.5f - v);
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

Vec2f coordinates_of(const Vec3f& d) {
  const float u = 0.5f - std::atan2(d.y, d.x) / (2.0f * kPi);
  const float v = 0.5f - std::asin(std::clamp(d.z, -1.0f, 1.0f)) / kPi;
  return {u - std::floor(u), v};
}

float luminance(const float* rgb) { return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]; }

// Index of the interval of a rising table that holds u * last, and the position inside it.
std::pair<int, float> found(const float* cdf, int n, float u) {
  const float target = u * cdf[n];
  int i = static_cast<int>(std::upper_bound(cdf, cdf + n + 1, target) - cdf) - 1;
  i = std::clamp(i, 0, n - 1);
  const float width = cdf[i + 1] - cdf[i];
  return {i, width > 0 ? std::clamp((target - cdf[i]) / width, 0.0f, 0.9999f) : 0.5f};
}

float blob(const Vec3f& d, const Vec3f& towards, float radius_deg, float softness) {
  const float angle = std::acos(std::clamp(dot(d, normalized(towards)), -1.0f, 1.0f)) * 180.0f / kPi;
  return 1.0f - smooth_step(radius_deg * (1 - softness), radius_deg * (1 + softness), angle);
}

float clouds(const Vec3f& d, float cover, uint32_t seed) {
  const Vec3f on_sheet = (1.0f / (std::max(d.z, 0.0f) + 0.22f)) * Vec3f{d.x, d.y, 0};
  return smooth_step(cover, cover + 0.28f, fractal_noise(1.7f * on_sheet + Vec3f{3, 7, 1}, 5, seed));
}

Vec3f ground(const Vec3f& d, const Vec3f& colour) { return (0.6f + 0.8f * fractal_noise(6.0f * d, 3, 91)) * colour; }

}  // namespace

Environment::Environment(ImageF rgb) : map_(std::move(rgb)) {
  for (float& value : map_.data()) value = static_cast<float>(Imath::half(value));
  build_tables([](const Vec3f&) { return 1.0f; });
}

void Environment::weigh_sampling(const std::function<float(const Vec3f&)>& share) {
  if (!black()) build_tables(share);
}

void Environment::build_tables(const std::function<float(const Vec3f&)>& share) {
  const int w = map_.width(), h = map_.height();
  const size_t stride = static_cast<size_t>(w) + 1;
  row_cdf_.assign(static_cast<size_t>(h) + 1, 0);
  column_cdf_.assign(static_cast<size_t>(h) * stride, 0);
  for (int y = 0; y < h; ++y) {
    const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(h);
    float* row = &column_cdf_[static_cast<size_t>(y) * stride];
    for (int x = 0; x < w; ++x) {
      const Vec3f d = direction_at((static_cast<float>(x) + 0.5f) / static_cast<float>(w), v);
      row[x + 1] = row[x] + std::sin(kPi * v) * (share(d) + kLeastShare) * (luminance(map_.pixel(x, y)) + 1e-4f);
    }
    row_cdf_[static_cast<size_t>(y) + 1] = row_cdf_[static_cast<size_t>(y)] + row[w];
  }
  total_ = row_cdf_.back();
}

Vec3f Environment::radiance(const Vec3f& direction) const {
  if (black()) return {};
  const int w = map_.width(), h = map_.height();
  const Vec2f uv = coordinates_of(direction);
  const float fx = uv.x * static_cast<float>(w) - 0.5f, fy = uv.y * static_cast<float>(h) - 0.5f;
  const int x = static_cast<int>(std::floor(fx)), y = static_cast<int>(std::floor(fy));
  const float tx = fx - static_cast<float>(x), ty = fy - static_cast<float>(y);
  const auto texel = [&](int i, int j) {
    const float* p = map_.pixel((i % w + w) % w, std::clamp(j, 0, h - 1));  // wraps around, ends at the poles
    return Vec3f{p[0], p[1], p[2]};
  };
  return mixed(mixed(texel(x, y), texel(x + 1, y), tx), mixed(texel(x, y + 1), texel(x + 1, y + 1), tx), ty);
}

Environment::Direction Environment::sample(const Vec2f& u) const {
  const int w = map_.width(), h = map_.height();
  const auto [y, ty] = found(row_cdf_.data(), h, u.y);
  const auto [x, tx] = found(&column_cdf_[static_cast<size_t>(y) * (static_cast<size_t>(w) + 1)], w, u.x);
  const Vec3f d =
      direction_at((static_cast<float>(x) + tx) / static_cast<float>(w), (static_cast<float>(y) + ty) / static_cast<float>(h));
  return {d, pdf(d)};
}

float Environment::pdf(const Vec3f& direction) const {
  if (black()) return 0;
  const int w = map_.width(), h = map_.height();
  const Vec2f uv = coordinates_of(direction);
  const int x = std::min(static_cast<int>(uv.x * static_cast<float>(w)), w - 1);
  const int y = std::min(static_cast<int>(uv.y * static_cast<float>(h)), h - 1);
  const float* row = &column_cdf_[static_cast<size_t>(y) * (static_cast<size_t>(w) + 1)];
  const float cells = static_cast<float>(w) * static_cast<float>(h);
  const float jacobian = 2.0f * kPi * kPi * std::max(std::sin(kPi * uv.y), 1e-6f);  // d(direction) / d(u,v)
  return (row[x + 1] - row[x]) / total_ * cells / jacobian;
}

Environment painted_environment(int width, const std::function<Vec3f(const Vec3f&)>& radiance, float radiosity) {
  constexpr int kSide = 3;
  const int height = width / 2;
  ImageF map(width, height, 3);
  parallel_for(static_cast<size_t>(height), 1, [&](size_t row) {
    for (int x = 0; x < width; ++x) {
      Vec3f sum{};
      for (int s = 0; s < kSide * kSide; ++s)
        sum += radiance(direction_at(
            (static_cast<float>(x) + (static_cast<float>(s % kSide) + 0.5f) / kSide) / static_cast<float>(width),
            (static_cast<float>(row) + (static_cast<float>(s / kSide) + 0.5f) / kSide) / static_cast<float>(height)));
      for (int c = 0; c < 3; ++c)
        map.at(x, static_cast<int>(row), c) = sum[static_cast<size_t>(c)] / static_cast<float>(kSide * kSide);
    }
  });
  double irradiance = 0;
  for (int y = 0; y < height / 2; ++y)
    for (int x = 0; x < width; ++x) {
      const double theta = std::numbers::pi * (y + 0.5) / height;
      irradiance += static_cast<double>(luminance(map.pixel(x, y))) * std::cos(theta) * std::sin(theta) * 2 * std::numbers::pi *
                    std::numbers::pi / (static_cast<double>(width) * height);
    }
  const float scale = static_cast<float>(radiosity * std::numbers::pi / irradiance);
  for (float& value : map.data()) value *= scale;
  return Environment(std::move(map));
}

Vec3f noon_sky(const Vec3f& d) {
  if (d.z < 0) return ground(d, {0.16f, 0.14f, 0.11f});
  const Vec3f blue = mixed({0.85f, 0.95f, 1.1f}, {0.28f, 0.48f, 0.95f}, std::pow(std::min(d.z, 1.0f), 0.6f));
  const Vec3f sky = mixed(blue, {1.5f, 1.48f, 1.45f}, 0.85f * clouds(d, 0.42f, 11));
  const Vec3f sun{-0.45f, 0.38f, 0.80f};
  return sky + (36.0f * blob(d, sun, 4.5f, 0.5f) + 1.5f * blob(d, sun, 20.0f, 0.9f)) * Vec3f{1.0f, 0.93f, 0.82f};
}

Vec3f sunset_sky(const Vec3f& d) {
  if (d.z < 0) return ground(d, {0.07f, 0.05f, 0.05f});
  const Vec3f sky = mixed({1.0f, 0.42f, 0.20f}, {0.14f, 0.18f, 0.42f}, smooth_step(0.0f, 0.65f, d.z));
  const Vec3f lit = mixed(sky, {1.1f, 0.45f, 0.38f}, 0.7f * clouds(d, 0.46f, 23));
  const Vec3f sun{0.72f, -0.30f, 0.62f};
  return lit + (48.0f * blob(d, sun, 5.0f, 0.5f) + 2.0f * blob(d, sun, 24.0f, 0.9f)) * Vec3f{1.0f, 0.55f, 0.26f};
}

Vec3f studio_lights(const Vec3f& d) {
  Vec3f sum = (0.05f + 0.04f * fractal_noise(4.0f * d, 2, 37)) * Vec3f{1, 1, 1};
  const auto soft_box = [&](const Vec3f& towards, float half_u, float half_v, const Vec3f& colour) {
    const Vec3f n = normalized(towards), u = normalized(cross(Vec3f{0, 0, 1}, n)), v = cross(n, u);
    const float facing = dot(d, n);
    if (facing <= 0) return;
    const float a = std::abs(dot(d, u) / facing) / half_u, b = std::abs(dot(d, v) / facing) / half_v;
    sum += (1.0f - smooth_step(0.9f, 1.1f, std::max(a, b))) * colour;
  };
  soft_box({0.5f, 0.6f, 1.1f}, 0.30f, 0.42f, {14, 13.5f, 12.5f});
  soft_box({-0.9f, -0.2f, 0.9f}, 0.45f, 0.16f, {5, 6.5f, 9});
  soft_box({0.3f, -1.0f, 0.9f}, 0.12f, 0.40f, {9, 5.5f, 3.5f});
  return sum;
}

}  // namespace vitrine::generate
