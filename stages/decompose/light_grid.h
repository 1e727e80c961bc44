// Grid of directions with equal solid angle: bands of equal height in z (Archimedes), divided into azimuths. The unknown light is
// constant per cell.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/foundation/math/vec.h"

namespace vitrine {

struct LightGrid {
  size_t bands = 16;  // from +z to -z
  size_t azimuths() const { return 2 * bands; }
  size_t cells() const { return bands * azimuths(); }
  float solid_angle() const { return 4 * std::numbers::pi_v<float> / static_cast<float>(cells()); }

  // u, v in [0, 1): position in the cell.
  Vec3f direction(size_t cell, float u, float v) const {
    const float z = 1 - 2 * (static_cast<float>(cell / azimuths()) + v) / static_cast<float>(bands);
    const float a = 2 * std::numbers::pi_v<float> * (static_cast<float>(cell % azimuths()) + u) / static_cast<float>(azimuths());
    const float r = std::sqrt(std::max(0.f, 1 - z * z));
    return {r * std::cos(a), r * std::sin(a), z};
  }
  size_t cell_of(const Vec3f& d) const {
    const float turn = std::atan2(d.y, d.x) / (2 * std::numbers::pi_v<float>);
    const auto index = [](float x, size_t n) {
      return static_cast<size_t>(std::clamp(x * static_cast<float>(n), 0.f, static_cast<float>(n) - 0.5f));
    };
    return index((1 - d.z) / 2, bands) * azimuths() + index(turn < 0 ? turn + 1 : turn, azimuths());
  }
  // Neighbour to the east, and to the south (cells() in the last band).
  size_t east(size_t cell) const { return cell - cell % azimuths() + (cell + 1) % azimuths(); }
  size_t south(size_t cell) const { return cell + azimuths() < cells() ? cell + azimuths() : cells(); }
};

}  // namespace vitrine
