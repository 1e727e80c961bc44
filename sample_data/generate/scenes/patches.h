// Paint of the scenes for tests: so coarse that small pictures resolve it.
#pragma once

#include "sample_data/generate/texture.h"

namespace vitrine::generate {

// Soft-edged patches of random colours around a base colour, with broad shading under them.
inline Texture patches(const Vec3f& base, float size, uint32_t seed) {
  return [=](const SurfacePoint& s) {
    const Vec3f warp =
        0.35f * Vec3f{value_noise((1.0f / size) * s.position, seed + 1), value_noise((1.0f / size) * s.position, seed + 2),
                      value_noise((1.0f / size) * s.position, seed + 3)};
    const CellNoise cell = cell_noise((1.0f / size) * s.position + warp, seed);
    const Vec3f tint{unit_float(cell.cell), unit_float(cell.cell * 0x9e3779b1u), unit_float(cell.cell * 0x85ebca77u)};
    const float border = smooth_step(0.02f, 0.16f, cell.second - cell.nearest);
    const float shade = 0.55f + 0.45f * fractal_noise((2.5f / size) * s.position, 3, seed + 4);
    return shade * mixed(0.25f * base, hadamard(base, 0.35f * Vec3f{1, 1, 1} + 0.95f * tint), border);
  };
}

}  // namespace vitrine::generate
