#include "sample_data/generate/scenes/gallery_paint.h"

#include <algorithm>
#include <cmath>

namespace vitrine::generate {
namespace {

Vec3f from_hsv(float hue, float saturation, float value) {
  const auto channel = [&](float shift) {
    const float k = std::fmod(hue + shift, 1.0f);
    const float tooth = std::clamp(std::abs(6.0f * k - 3.0f) - 1.0f, 0.0f, 1.0f);
    return value * (1.0f - saturation * (1.0f - tooth));
  };
  return {channel(0), channel(2.0f / 3.0f), channel(1.0f / 3.0f)};
}

const Vec3f& colour_of(const Palette& palette, uint32_t hash) { return palette[(hash >> 4) % palette.size()]; }

// Fine wear over a colour, the smallest scale of every pattern.
float wear(const Vec3f& p, float size, uint32_t seed) { return 0.68f + 0.5f * fractal_noise((5.0f / size) * p, 4, seed); }

}  // namespace

Palette drawn_palette(Draw& draw, int colours) {
  // Hues spread around the circle from a random start; light and dark take turns, so that neighbours differ.
  Palette palette;
  const float start = draw.between(0, 1);
  for (int i = 0; i < colours; ++i) {
    const float hue = std::fmod(start + 0.618f * static_cast<float>(i) + draw.between(-0.05f, 0.05f) + 1.0f, 1.0f);
    palette.push_back(i % 2 ? from_hsv(hue, draw.between(0.15f, 0.55f), draw.between(0.5f, 0.85f))
                            : from_hsv(hue, draw.between(0.5f, 0.9f), draw.between(0.10f, 0.38f)));
  }
  return palette;
}

Vec3f drawn_metal_colour(Draw& draw) {
  static const std::vector<Vec3f> metals = {{0.95f, 0.93f, 0.88f}, {1.00f, 0.77f, 0.34f}, {0.95f, 0.64f, 0.54f},
                                            {0.89f, 0.75f, 0.44f}, {0.62f, 0.60f, 0.58f}, {0.76f, 0.78f, 0.80f},
                                            {0.91f, 0.92f, 0.92f}, {0.55f, 0.50f, 0.47f}};
  const Vec3f metal = draw.pick(metals);
  return hadamard(metal, {draw.between(0.92f, 1), draw.between(0.92f, 1), draw.between(0.92f, 1)});
}

Texture patchwork(const Palette& palette, float size, uint32_t seed) {
  return [=](const SurfacePoint& s) {
    const Vec3f p = (1.0f / size) * s.position;
    const Vec3f warp =
        0.35f * Vec3f{value_noise(2.0f * p, seed + 1), value_noise(2.0f * p, seed + 2), value_noise(2.0f * p, seed + 3)};
    const CellNoise cell = cell_noise(p + warp, seed);
    const Vec3f colour = (0.65f + 0.5f * unit_float(cell.cell * 0x9e3779b1u)) * colour_of(palette, cell.cell);
    const CellNoise dot = cell_noise(4.5f * p, seed + 5);
    const bool dotted = unit_float(dot.cell) < 0.3f;
    const Vec3f inlay =
        mixed(colour_of(palette, dot.cell * 0x85ebca77u), colour, dotted ? smooth_step(0.22f, 0.30f, dot.nearest) : 1.0f);
    return wear(s.position, size, seed + 9) *
           mixed({0.05f, 0.045f, 0.04f}, inlay, smooth_step(0.02f, 0.07f, cell.second - cell.nearest));
  };
}

Texture banded(const Palette& palette, float size, uint32_t seed) {
  return [=](const SurfacePoint& s) {
    const Vec3f& p = s.position;
    const float turn = std::atan2(p.y, p.x) / (2.0f * kPi) + 0.5f;
    const float height = p.z / (0.7f * size) + 0.12f * (fractal_noise((2.0f / size) * p, 2, seed) - 0.5f);
    const int band = static_cast<int>(std::floor(height));
    const uint32_t h = lattice_hash(band, 3, 1, seed);
    const float within = height - static_cast<float>(band);
    const int teeth = 7 + static_cast<int>(h % 9);
    const float u = turn * static_cast<float>(teeth);
    const int tooth = static_cast<int>(std::floor(u));
    const float x = u - static_cast<float>(tooth);
    const uint32_t piece = lattice_hash(band, tooth, 2, seed);
    Vec3f colour = colour_of(palette, h);
    const float zigzag = 0.25f + 0.5f * std::abs(2.0f * x - 1.0f);
    colour = mixed(colour, colour_of(palette, piece), smooth_step(-0.04f, 0.04f, within - zigzag));
    const float spot = std::hypot(x - 0.5f, 1.4f * (within - 0.55f));
    colour = mixed(colour_of(palette, piece * 0x9e3779b1u), colour, smooth_step(0.13f, 0.17f, spot));
    const float line = std::min(within, 1.0f - within);
    return wear(p, size, seed + 9) * mixed({0.05f, 0.045f, 0.04f}, colour, smooth_step(0.03f, 0.06f, line));
  };
}

Texture marbled(const Palette& palette, float size, uint32_t seed) {
  return [=](const SurfacePoint& s) {
    const Vec3f p = (1.0f / size) * s.position;
    const Vec3f fold{fractal_noise(1.3f * p, 4, seed), fractal_noise(1.3f * p, 4, seed + 11),
                     fractal_noise(1.3f * p, 4, seed + 23)};
    const float level = 3.99f * std::clamp(1.8f * fractal_noise(p + 2.2f * fold, 5, seed + 31) - 0.4f, 0.0f, 1.0f);
    const size_t step = static_cast<size_t>(level);
    const Vec3f &a = palette[step % palette.size()], &b = palette[(step + 1) % palette.size()];
    const float vein = smooth_step(0.0f, 0.05f, std::abs(fractal_noise(1.7f * p + 1.5f * fold, 5, seed + 41) - 0.5f));
    return wear(s.position, size, seed + 9) *
           mixed({0.72f, 0.69f, 0.62f}, mixed(a, b, smooth_step(0.2f, 0.8f, level - static_cast<float>(step))), vein);
  };
}

Texture speckled(const Palette& palette, float size, uint32_t seed) {
  return [=](const SurfacePoint& s) {
    const Vec3f p = (1.0f / size) * s.position;
    Vec3f colour = mixed(palette[0], palette[1 % palette.size()], smooth_step(0.35f, 0.65f, fractal_noise(1.1f * p, 4, seed)));
    for (const auto& [scale, share] : {std::pair{2.4f, 0.55f}, {6.5f, 0.5f}}) {
      const CellNoise speck = cell_noise(scale * p, seed + static_cast<uint32_t>(10.0f * scale));
      const float radius = 0.18f + 0.22f * unit_float(speck.cell * 0x85ebca77u);
      if (unit_float(speck.cell) < share)
        colour = mixed(colour_of(palette, speck.cell * 0x9e3779b1u), colour, smooth_step(radius, radius + 0.07f, speck.nearest));
    }
    return wear(s.position, size, seed + 9) * colour;
  };
}

Texture solid_pattern(Draw& draw, const Palette& palette, float size) {
  const uint32_t seed = draw.texture_seed();
  switch (draw.whole(0, 3)) {
    case 0:
      return patchwork(palette, size, seed);
    case 1:
      return banded(palette, size, seed);
    case 2:
      return marbled(palette, size, seed);
    default:
      return speckled(palette, size, seed);
  }
}

Texture flat_pattern(Draw& draw, const Palette& palette, float size) {
  return [painting = glyph_tiles(size, palette, draw.texture_seed())](const SurfacePoint& s) { return painting(s.uv.x, s.uv.y); };
}

Texture wooden(Draw& draw, size_t axis) {
  const Vec3f light = draw.chance(0.5f) ? from_srgb8(150, 98, 60) : from_srgb8(190, 150, 96);
  return solid_wood(axis, light, 0.4f * light, draw.texture_seed());
}

}  // namespace vitrine::generate
