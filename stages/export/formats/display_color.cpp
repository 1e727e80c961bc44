#include "stages/export/formats/display_color.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/color.h"
#include "core/math/spherical_harmonics.h"

namespace vitrine {

void encode_sh_for_display(std::span<float> sh) {
  const size_t coefficients = sh.size() / 3;
  for (size_t c = 0; c < 3; ++c) {
    const float linear = 0.5f + kShDc * sh[c];
    double energy = 0;  // of the higher bands: integral of their sum squared over the sphere
    for (size_t k = 1; k < coefficients; ++k) energy += double(sh[3 * k + c]) * sh[3 * k + c];
    const float spread = float(std::sqrt(energy / (4 * std::numbers::pi)));
    const float slope = srgb_from_linear_slope(std::max(linear, spread));
    sh[c] = (srgb_from_linear(std::max(linear, 0.f)) - 0.5f) / kShDc;
    for (size_t k = 1; k < coefficients; ++k) sh[3 * k + c] *= slope;
  }
}

}  // namespace vitrine
