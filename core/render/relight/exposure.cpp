#include "core/render/relight/exposure.h"

#include <cmath>

#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {
constexpr double kMiddleGrey = 0.18;
}

double exposure_of_scene(const LitScene& lit) {
  double sum = 0;
  for (const Vec3f& b : lit.radiance()) sum += 0.2126 * b.x + 0.7152 * b.y + 0.0722 * b.z;
  return sum > 0 ? std::round(10 * std::log2(kMiddleGrey * double(lit.radiance().size()) / sum)) / 10 : 0;
}

Image8 developed(const ImageF& radiance, double stops) {
  ImageF scaled = radiance;
  const auto gain = static_cast<float>(std::exp2(stops));
  for (float& v : scaled.data()) v *= gain;
  return srgb8_from_linear(scaled);
}

}  // namespace vitrine
