#include "sample_data/generate/scenes/owl.h"

#include <algorithm>
#include <cmath>

#include "sample_data/generate/paint.h"

namespace vitrine::generate {
namespace {

constexpr float kEyeX = 0.043f, kEyeY = -0.090f, kEyeZ = 0.352f;

// Rows of rounded feathers around the body, every second row shifted by half a feather, one colour each.
Vec3f plumage(const Vec3f& p) {
  constexpr float kRow = 0.034f;
  constexpr int kAround = 20;
  const Palette palette = {from_srgb8(44, 74, 120), from_srgb8(84, 54, 40),    from_srgb8(176, 112, 56), from_srgb8(38, 98, 98),
                           from_srgb8(138, 52, 44), from_srgb8(206, 170, 104), from_srgb8(92, 96, 110)};
  const float turn = (std::atan2(p.x, -p.y) / (2.0f * kPi) + 0.5f) * kAround;
  // A feather hangs from its row over the one below: the lower tip of the upper row wins where it reaches.
  const float height = p.z / kRow;
  for (int over = 1; over >= 0; --over) {
    const int row = static_cast<int>(std::floor(height)) + over;
    const float u = turn + (row & 1 ? 0.5f : 0.0f);
    const int column = static_cast<int>(std::floor(u)) % kAround;
    const float x = 2.0f * (u - std::floor(u)) - 1.0f, y = static_cast<float>(row) - height;  // y grows towards the tip
    const float below = std::max(0.0f, y - 0.25f), outline = x * x + 1.6f * below * below;
    if (over == 1 && outline > 0.95f) continue;
    const uint32_t h = lattice_hash(column, row, 0, 501);
    Vec3f colour = palette[h % palette.size()];
    const Vec3f pale = mixed(colour, {0.80f, 0.74f, 0.60f}, 0.75f);
    colour = mixed(colour, pale, smooth_step(0.60f, 0.78f, outline));      // light rim
    colour = mixed(pale, colour, smooth_step(0.05f, 0.11f, std::abs(x)));  // quill
    const float spot = std::hypot(std::abs(x) - 0.45f, y - 0.15f - 0.5f * unit_float(h * 0x9e3779b1u));
    if (h & 64) colour = mixed({0.78f, 0.72f, 0.58f}, colour, smooth_step(0.12f, 0.20f, spot));
    return colour;
  }
  return palette[0];
}

Vec3f belly(const Vec3f& p) {
  // Chevrons of uneven strength on cream.
  const float zig =
      p.z / 0.026f + 1.1f * std::abs(std::fmod(p.x / 0.024f + 20.0f, 2.0f) - 1.0f) + 1.3f * fractal_noise(18.0f * p, 2, 520);
  const float stripe = std::abs(zig - std::floor(zig) - 0.5f) * 2.0f;
  return mixed({0.26f, 0.13f, 0.07f}, {0.72f, 0.62f, 0.44f}, smooth_step(0.30f, 0.50f, stripe));
}

}  // namespace

float owl_distance(const Vec3f& p) {
  const Vec3f m{std::abs(p.x), p.y, p.z};  // mirror-symmetric
  float d = ellipsoid_distance(p, {0, 0.005f, 0.170f}, {0.112f, 0.098f, 0.172f});
  d = smooth_union(d, ellipsoid_distance(p, {0, -0.035f, 0.140f}, {0.085f, 0.075f, 0.120f}), 0.03f);
  d = smooth_union(d, ellipsoid_distance(p, {0, -0.010f, 0.338f}, {0.102f, 0.090f, 0.084f}), 0.035f);
  d = smooth_union(d, ellipsoid_distance(m, {0.104f, 0.012f, 0.175f}, {0.034f, 0.074f, 0.135f}), 0.015f);  // wings
  d = smooth_union(d, capsule_distance(m, {0.058f, -0.015f, 0.395f}, {0.084f, -0.020f, 0.452f}, 0.026f, 0.007f), 0.025f);
  d = smooth_union(d, ellipsoid_distance(p, {0, 0.088f, 0.085f}, {0.052f, 0.032f, 0.085f}), 0.02f);         // tail
  d = smooth_union(d, ellipsoid_distance(m, {0.045f, -0.082f, 0.020f}, {0.034f, 0.046f, 0.021f}), 0.008f);  // feet
  d = smooth_union(d, torus_distance(m, {kEyeX, kEyeY + 0.006f, kEyeZ}, normalized(Vec3f{0.35f, -1, 0.05f}), 0.030f, 0.0085f),
                   0.008f);
  d = smooth_union(d, ellipsoid_distance(m, {kEyeX, kEyeY + 0.012f, kEyeZ}, {0.024f, 0.018f, 0.024f}), 0.004f);
  d = smooth_union(d, capsule_distance(p, {0, -0.094f, 0.336f}, {0, -0.116f, 0.303f}, 0.017f, 0.005f), 0.008f);  // beak
  return d + 0.004f * (value_noise(34.0f * p, 540) - 0.5f);
}

Bounds3 owl_bounds() { return {{-0.16, -0.15, -0.015}, {0.16, 0.14, 0.475}}; }

Vec3f owl_colour(const Vec3f& p) {
  const Vec3f m{std::abs(p.x), p.y, p.z};
  const float worn = 0.70f + 0.45f * fractal_noise(26.0f * p, 4, 530);
  const float eye = std::hypot(m.x - kEyeX, p.z - kEyeZ);
  const bool face = p.y < -0.055f && p.z > 0.27f;
  if (p.y < -0.085f && m.x < 0.016f && p.z > 0.29f && p.z < 0.352f) return worn * Vec3f{0.75f, 0.34f, 0.05f};  // beak
  if (face && eye < 0.040f) {
    const float spokes = 0.5f + 0.5f * std::cos(14.0f * std::atan2(p.z - kEyeZ, m.x - kEyeX));
    Vec3f colour = mixed({0.02f, 0.02f, 0.025f}, {0.85f, 0.42f, 0.04f}, smooth_step(0.011f, 0.013f, eye));
    colour = mixed(colour, {0.10f, 0.06f, 0.04f}, smooth_step(0.021f, 0.023f, eye));
    return worn * mixed(colour, mixed({0.78f, 0.70f, 0.52f}, {0.45f, 0.22f, 0.10f}, spokes), smooth_step(0.026f, 0.028f, eye));
  }
  if (p.z < 0.042f && p.y < -0.05f) return worn * Vec3f{0.70f, 0.38f, 0.10f};  // feet
  const float front = (1.0f - smooth_step(-0.070f, -0.058f, p.y)) * (1.0f - smooth_step(0.262f, 0.275f, p.z)) *
                      (1.0f - smooth_step(0.072f, 0.080f, m.x));
  return worn * mixed(plumage(p), belly(p), front);
}

}  // namespace vitrine::generate
