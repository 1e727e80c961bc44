#include "sample_data/generate/paint.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/foundation/base/rng.h"

namespace vitrine::generate {
namespace {

Vec2f turned(const Vec2f& p, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return {c * p.x + s * p.y, c * p.y - s * p.x};
}
float norm(const Vec2f& p) { return std::hypot(p.x, p.y); }
float bar(const Vec2f& p, float half_x, float half_y) { return std::max(std::abs(p.x) - half_x, std::abs(p.y) - half_y); }
float segment(const Vec2f& p, const Vec2f& a, const Vec2f& b) {
  const Vec2f ab = b - a, ap = p - a;
  const float t = std::clamp((ap.x * ab.x + ap.y * ab.y) / (ab.x * ab.x + ab.y * ab.y), 0.0f, 1.0f);
  return norm(ap - t * ab);
}
float triangle(const Vec2f& p, float radius) {
  return std::max({-p.y, 0.866f * p.x + 0.5f * p.y, -0.866f * p.x + 0.5f * p.y}) - 0.5f * radius;
}

const Vec3f& pick(const Palette& palette, uint32_t hash) { return palette[hash % palette.size()]; }

// Distance to the figure of a tile in [-1,1]^2; negative on it.
float glyph(const Vec2f& p, uint32_t h) {
  const Vec2f q = turned(p, 0.5f * kPi * static_cast<float>(h >> 28 & 3) + 0.5f * (unit_float(h * 0x9e3779b1u) - 0.5f));
  switch (h % 8) {
    case 0:
      return std::abs(norm(q) - 0.52f) - 0.14f;  // ring
    case 1:
      return std::max(norm(q) - 0.66f, 0.52f - norm(q - Vec2f{0.28f, 0.12f}));  // crescent
    case 2:
      return norm(q) - 0.34f - 0.26f * std::cos(5.0f * std::atan2(q.y, q.x));  // star, flower
    case 3:
      return std::min(bar(q, 0.62f, 0.13f), bar(q - Vec2f{0.2f, 0}, 0.13f, 0.62f));  // cross off its centre
    case 4:
      return triangle(q, 0.62f);
    case 5:
      return std::min(bar(q - Vec2f{0, 0.42f}, 0.6f, 0.12f),
                      std::min(bar(q + Vec2f{0.3f, 0}, 0.12f, 0.6f), norm(q - Vec2f{0.3f, -0.3f}) - 0.2f));
    default: {  // a letter of strokes
      float d = 1e9f;
      for (uint32_t stroke = 0; stroke < 4; ++stroke) {
        const uint32_t k = lattice_hash(static_cast<int>(stroke), 5, 7, h);
        const auto knot = [](uint32_t i) {
          return Vec2f{0.55f * (static_cast<float>(i % 3) - 1.0f), 0.55f * (static_cast<float>(i / 3 % 3) - 1.0f)};
        };
        const uint32_t from = k % 9, to = (from + 1 + (k >> 8) % 8) % 9;
        d = std::min(d, segment(q, knot(from), knot(to)) - 0.115f);
      }
      return d;
    }
  }
}

}  // namespace

Palette ceramic_palette() {
  return {from_srgb8(28, 60, 120),   from_srgb8(196, 64, 44), from_srgb8(232, 176, 60), from_srgb8(40, 116, 104),
          from_srgb8(236, 226, 204), from_srgb8(120, 44, 66), from_srgb8(92, 150, 190), from_srgb8(66, 52, 44),
          from_srgb8(214, 128, 90),  from_srgb8(150, 168, 92)};
}

Palette book_palette() {
  return {from_srgb8(150, 40, 38), from_srgb8(226, 196, 130), from_srgb8(36, 66, 58), from_srgb8(220, 214, 200),
          from_srgb8(48, 52, 92)};
}

Painting glyph_tiles(float tile, const Palette& palette, uint32_t seed) {
  return [=](float x, float y) {
    const int i = static_cast<int>(std::floor(x / tile)), j = static_cast<int>(std::floor(y / tile));
    const uint32_t h = lattice_hash(i, j, 0, seed);
    const Vec2f p{2.0f * (x / tile - static_cast<float>(i)) - 1.0f, 2.0f * (y / tile - static_cast<float>(j)) - 1.0f};
    const Vec3f at = (1.0f / tile) * Vec3f{x, y, 0};
    const Vec3f ground = mixed(pick(palette, h >> 3), {0.75f, 0.70f, 0.60f}, 0.55f * unit_float(h * 0x2c1b3c6du));
    Vec3f figure = pick(palette, h >> 11), corner = pick(palette, h >> 19);
    if (length(figure - ground) < 0.25f)
      figure = dot(ground, Vec3f{1, 1, 1}) > 0.9f ? Vec3f{0.04f, 0.05f, 0.09f} : Vec3f{0.78f, 0.74f, 0.66f};
    const float wobble = 0.10f * (fractal_noise(5.0f * at, 2, seed + 1) - 0.5f);  // painted by hand
    Vec3f colour = mixed(figure, ground, smooth_step(-0.03f, 0.03f, glyph(p, h) + wobble));
    // Quarter discs in the corners differ from tile to tile, so no lattice appears.
    for (int c = 0; c < 4; ++c) {
      const Vec2f q = p - Vec2f{c & 1 ? 1.0f : -1.0f, c & 2 ? 1.0f : -1.0f};
      const float radius = 0.10f + 0.34f * unit_float(lattice_hash(i + (c & 1), j + (c >> 1), 3, seed));
      colour = mixed(corner, colour, smooth_step(-0.03f, 0.03f, norm(q) - radius + wobble));
    }
    const float joint = smooth_step(0.94f, 0.975f, std::max(std::abs(p.x), std::abs(p.y)));
    colour = mixed(colour, {0.20f, 0.18f, 0.16f}, joint);
    const float glaze = 0.72f + 0.40f * fractal_noise(3.1f * at, 5, seed + 2);
    const float crazing = 1.0f - 0.25f * smooth_step(0.62f, 0.75f, fractal_noise(9.0f * at, 3, seed + 3));
    return glaze * crazing * colour;
  };
}

Painting abstract_picture(float width, float height, uint32_t seed) {
  struct Figure {
    int kind;
    Vec2f centre;
    float size, ratio, angle;
    Vec3f colour;
  };
  const Palette palette = ceramic_palette();
  auto figures = std::make_shared<std::vector<Figure>>();
  Rng rng(seed, 77);
  const float side = std::min(width, height);
  constexpr int kFigures = 46;
  for (int i = 0; i < kFigures; ++i) {
    // Big ones first: the later and smaller ones are painted over them.
    const float size =
        side * std::lerp(0.34f, 0.035f, std::pow(static_cast<float>(i) / kFigures, 0.6f)) * (0.7f + 0.6f * rng.uniform());
    const int kind = static_cast<int>(rng.below(5));
    const Vec2f centre{width * rng.uniform(), height * rng.uniform()};
    const float ratio = 0.2f + 0.6f * rng.uniform(), angle = 2.0f * kPi * rng.uniform();
    figures->push_back({kind, centre, size, ratio, angle,
                        (0.6f + 0.5f * rng.uniform()) * palette[rng.below(static_cast<uint32_t>(palette.size()))]});
  }
  const Vec3f top = palette[rng.below(10)], bottom = palette[rng.below(10)];
  return [=](float x, float y) {
    const float canvas = 0.78f + 0.36f * fractal_noise((14.0f / side) * Vec3f{x, y, 0}, 4, seed);
    Vec3f colour = mixed(mixed(bottom, top, y / height), {0.6f, 0.57f, 0.5f}, 0.35f);
    for (const Figure& f : *figures) {
      const Vec2f q = (1.0f / f.size) * turned(Vec2f{x, y} - f.centre, f.angle);
      float d = 0;
      if (f.kind == 0) d = norm(q) - 1.0f;
      if (f.kind == 1) d = std::abs(norm(q) - 0.8f) - 0.22f * f.ratio - 0.05f;
      if (f.kind == 2) d = bar(q, 1.1f, 0.35f * f.ratio + 0.06f);
      if (f.kind == 3) d = triangle(q, 1.2f);
      if (f.kind == 4) d = bar(q, 0.8f, 0.8f * f.ratio + 0.1f);
      colour = mixed(f.colour, colour, smooth_step(-0.02f, 0.02f, d));
    }
    return canvas * colour;
  };
}

Painting planks(float plank, const Vec3f& light, const Vec3f& dark, uint32_t seed) {
  return [=](float x, float y) {
    const int row = static_cast<int>(std::floor(y / plank));
    const float shift = 3.0f * unit_float(lattice_hash(row, 1, 1, seed));
    const float board = 1.1f + 0.7f * unit_float(lattice_hash(row, 2, 1, seed));
    const int piece = static_cast<int>(std::floor((x + shift) / board));
    const uint32_t h = lattice_hash(row, piece, 2, seed);
    const Vec3f p{x * 1.8f + 31.0f * unit_float(h), y * 26.0f, 9.0f * unit_float(h * 0x9e3779b1u)};
    const float grain = fractal_noise(p, 5, seed + 1);
    const float rings = 0.5f + 0.5f * std::sin(24.0f * (fractal_noise({0.35f * p.x, 0.12f * p.y, p.z}, 3, seed + 2)));
    Vec3f colour = (0.65f + 0.6f * unit_float(h * 0x85ebca77u)) * mixed(dark, light, 0.65f * grain + 0.35f * rings);
    const float edge_y = std::abs(y / plank - static_cast<float>(row) - 0.5f) * 2.0f;
    const float edge_x = std::abs((x + shift) / board - static_cast<float>(piece) - 0.5f) * 2.0f;
    colour = 0.25f * colour +
             (0.75f * (1.0f - std::max(smooth_step(0.93f, 0.98f, edge_y), smooth_step(0.992f, 0.998f, edge_x)))) * colour;
    const CellNoise knot = cell_noise({x * 1.6f, y * 3.2f, 0.5f}, seed + 3);
    return mixed(0.25f * dark, colour, smooth_step(0.08f, 0.22f, knot.nearest + 0.1f * (grain - 0.5f)));
  };
}

Texture solid_wood(size_t axis, const Vec3f& light, const Vec3f& dark, uint32_t seed) {
  return [=](const SurfacePoint& s) {
    Vec3f p = 30.0f * s.position;
    p[axis] *= 0.12f;
    const float grain = fractal_noise(p, 4, seed), blotch = fractal_noise(9.0f * s.position, 3, seed + 1);
    const float rings = 0.5f + 0.5f * std::sin(16.0f * fractal_noise(0.25f * p, 2, seed + 2));
    return (0.7f + 0.6f * blotch) * mixed(dark, light, 0.6f * grain + 0.4f * rings);
  };
}

Texture plaster(const Vec3f& base, const Vec3f& stain, uint32_t seed) {
  return [=](const SurfacePoint& s) {
    const float broad = fractal_noise(1.6f * s.position, 5, seed);
    const CellNoise chips = cell_noise(7.0f * s.position + 0.6f * Vec3f{broad, broad, -broad}, seed + 1);
    const float chipped = unit_float(chips.cell) < 0.38f ? 1.0f - smooth_step(0.20f, 0.26f, chips.nearest) : 0.0f;
    const float fine = fractal_noise(22.0f * s.position, 3, seed + 2);
    const Vec3f coat = (0.80f + 0.30f * fine) * mixed(base, stain, smooth_step(0.42f, 0.62f, broad));
    return mixed(coat, (0.35f + 0.5f * unit_float(chips.cell * 0x9e3779b1u)) * hadamard(stain, Vec3f{1.1f, 0.9f, 0.8f}),
                 0.8f * chipped);
  };
}

}  // namespace vitrine::generate
