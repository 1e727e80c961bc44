// The coated things of the gallery: paint under a clear layer, which is sharp or a little rough.
#include <algorithm>
#include <cmath>

#include "sample_data/generate/scenes/gallery_paint.h"
#include "sample_data/generate/scenes/gallery_pieces.h"

namespace vitrine::generate {
namespace {

constexpr float kCoatCell = 0.0085f;  // also of the light on the base, metres

Material coat_over(Draw& draw, Texture base) {
  const float roughness = draw.chance(0.5f) ? 0.0f : draw.between(0.08f, 0.3f);
  return {.kind = MaterialKind::Coat, .albedo = std::move(base), .roughness = roughness};
}

float rounded_box_distance(const Vec3f& p, const Vec3f& centre, const Vec3f& half, float round) {
  const Vec3f q = p - centre;
  const Vec3f out{std::max(std::abs(q.x) - half.x + round, 0.0f), std::max(std::abs(q.y) - half.y + round, 0.0f),
                  std::max(std::abs(q.z) - half.z + round, 0.0f)};
  const float in = std::max({std::abs(q.x) - half.x, std::abs(q.y) - half.y, std::abs(q.z) - half.z}) + round;
  return length(out) + std::min(in, 0.0f) - round;
}

}  // namespace

Piece glazed_pot(Draw& draw) {
  Piece piece;
  const float r = draw.between(0.085f, 0.11f), high = draw.between(0.19f, 0.27f), belly = draw.between(0.35f, 0.5f);
  const float mouth = r * draw.between(0.55f, 0.75f), tube = draw.between(0.011f, 0.015f);
  const DistanceFunction pot = [=](const Vec3f& p) {
    const float body = ellipsoid_distance(p, {0, 0, belly * high}, {r, r, 0.58f * high});
    const float neck = capsule_distance(p, {0, 0, 0.6f * high}, {0, 0, high}, mouth, mouth);
    float d = std::max(smooth_union(body, neck, 0.04f), p.z - high);
    const float hollow = std::min(capsule_distance(p, {0, 0, 0.75f * high}, {0, 0, 1.3f * high}, mouth - 0.012f, mouth - 0.012f),
                                  ellipsoid_distance(p, {0, 0, belly * high}, {r - 0.014f, r - 0.014f, 0.5f * high}));
    const float handle = torus_distance(p, {r + 0.002f, 0, 0.55f * high}, {0, 1, 0}, 0.26f * high, tube);
    d = smooth_union(d, handle, 0.012f);
    d = -smooth_union(-d, hollow, 0.006f);
    return -smooth_union(-d, p.z - 0.0005f, 0.01f);
  };
  const double b = static_cast<double>(r + 0.3f * high) + 0.04;
  Shape shape = meshed(pot,
                       {{-static_cast<double>(r) - 0.02, -static_cast<double>(r) - 0.02, -0.012},
                        {b, static_cast<double>(r) + 0.02, static_cast<double>(high) + 0.02}},
                       kCoatCell);
  add_part(piece, "coat", std::move(shape),
           coat_over(draw, solid_pattern(draw, drawn_palette(draw, 7), draw.between(0.05f, 0.09f))));
  return piece;
}

Piece toy_car(Draw& draw) {
  Piece piece;
  const float half = draw.between(0.17f, 0.21f), wide = half * draw.between(0.42f, 0.5f), low = 0.14f * half,
              waist = half * draw.between(0.42f, 0.5f);
  const float cabin = half * draw.between(0.45f, 0.55f), roof = waist + half * draw.between(0.22f, 0.32f),
              back = draw.between(-0.2f, 0.05f) * half;
  const float wheel = 0.17f * half;
  const float axles[2] = {-0.58f * half, 0.6f * half};
  const DistanceFunction body = [=](const Vec3f& p) {
    float d = rounded_box_distance(p, {0, 0, 0.5f * (low + waist)}, {half, wide, 0.5f * (waist - low)}, 0.3f * half * 0.5f);
    d = smooth_union(d, ellipsoid_distance(p, {back, 0, waist}, {cabin, 0.86f * wide, roof - waist}), 0.03f);
    d = smooth_union(d, ellipsoid_distance(p, {0.55f * half, 0, waist - 0.02f * half}, {0.4f * half, 0.75f * wide, 0.10f * half}),
                     0.03f);
    for (const float x : axles) {  // room for the wheels
      const float arch = std::max(std::hypot(p.x - x, p.z - wheel) - 1.25f * wheel, 0.62f * wide - std::abs(p.y));
      d = -smooth_union(-d, arch, 0.008f);
    }
    return d;
  };
  const double l = static_cast<double>(half) + 0.02, w = static_cast<double>(wide) + 0.02;
  // One main colour with a fine grain, stripes of a second one along the car, dark panes.
  const Palette palette = drawn_palette(draw, 6);
  const Vec3f main = palette[0], second = palette[1];
  const uint32_t seed = draw.texture_seed();
  const float stripe = draw.between(0.15f, 0.4f) * wide;
  const Texture decals = patchwork(palette, 0.05f, seed + 50);
  const Texture paint = [=](const SurfacePoint& s) {
    const Vec3f& p = s.position;
    const float grain = 0.75f + 0.35f * fractal_noise(60.0f * p, 3, seed) + 0.2f * (fractal_noise(9.0f * p, 3, seed + 7) - 0.5f);
    Vec3f colour = mixed(second, main, smooth_step(-0.003f, 0.003f, std::abs(std::abs(p.y) - stripe) - 0.012f));
    const bool on_side = std::abs(p.y) > 0.7f * wide && p.z < waist && std::abs(p.x - back) < 0.45f * half && p.z > 0.4f * waist;
    if (on_side) colour = decals(s);
    const float pane = std::max(std::abs(p.z - 0.5f * (waist + roof) - 0.004f) - 0.3f * (roof - waist),
                                std::abs(std::abs(p.x - back) - 0.45f * cabin) - 0.36f * cabin);
    return grain * mixed({0.03f, 0.035f, 0.045f}, colour, smooth_step(-0.002f, 0.002f, pane));
  };
  add_part(piece, "coat", meshed(body, {{-l, -w, 0.005}, {l, w, static_cast<double>(roof) + 0.03}}, kCoatCell),
           coat_over(draw, paint));
  Shape wheels;
  for (const float x : axles)
    for (const float side : {-1.0f, 1.0f}) {
      const float y = side * 0.80f * wide;
      const Vec3f hub{x, y, wheel + 0.0005f};
      const DistanceFunction tyre = [=](const Vec3f& p) {
        return rounded_box_distance({std::hypot(p.x - hub.x, p.z - hub.z), p.y - hub.y, 0}, {0, 0, 0},
                                    {wheel, 0.13f * half * 0.6f, 1}, 0.006f);
      };
      const Vec3d c = cast<double>(hub);
      const double e = static_cast<double>(wheel) + 0.012;
      append(wheels, meshed(tyre, {{c.x - e, c.y - 0.03, c.z - e}, {c.x + e, c.y + 0.03, c.z + e}}, 0.0065f));
    }
  add_part(piece, "wheels", wheels, {.albedo = [seed](const SurfacePoint& s) {
             return (0.03f + 0.08f * fractal_noise(90.0f * s.position, 3, seed)) * Vec3f{1, 1, 1};
           }});
  return piece;
}

Piece lacquered_box(Draw& draw) {
  Piece piece;
  const Vec3f half{draw.between(0.10f, 0.14f), draw.between(0.075f, 0.10f), draw.between(0.05f, 0.08f)};
  const float round = draw.between(0.008f, 0.02f), gap = draw.between(0.6f, 0.75f);
  const DistanceFunction chest = [=](const Vec3f& p) {
    const float d = rounded_box_distance(p, {0, 0, half.z + 0.0005f}, half, round);
    // A groove around it where the lid begins.
    const float groove = std::max(std::abs(p.z - 2.0f * gap * half.z) - 0.004f, -d - 0.004f);
    return std::max(d, -groove);
  };
  const Vec3d h = cast<double>(half) + Vec3d{0.015, 0.015, 0.015};
  add_part(piece, "coat", meshed(chest, {{-h.x, -h.y, -0.015}, {h.x, h.y, 2 * h.z}}, 0.006f),
           coat_over(draw, solid_pattern(draw, drawn_palette(draw, 6), draw.between(0.05f, 0.08f))));
  return piece;
}

}  // namespace vitrine::generate
