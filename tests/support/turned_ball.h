// A ball as a surface of revolution.
#pragma once

#include <cmath>
#include <numbers>

#include "core/scene/shape/surface_of_revolution.h"

namespace vitrine::test {

inline SurfaceOfRevolution turned_ball(const Vec3d& centre, double radius) {
  constexpr int kLines = 32;
  SurfaceOfRevolution out{centre, {0, 0, 1}, {}};
  for (int i = 0; i <= kLines; ++i) {
    const double angle = std::numbers::pi * (double(i) / kLines - 0.5);
    out.profile.push_back({i % kLines == 0 ? 0 : radius * std::cos(angle), radius * std::sin(angle)});
  }
  return out;
}

}  // namespace vitrine::test
