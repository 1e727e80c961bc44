#include "stages/view/relit_sample.h"

#include <algorithm>

#include "core/scene/image/ldr.h"
#include "core/render/relight/exposure.h"
#include "core/render/relight/relit_painter.h"

namespace vitrine {

namespace {
constexpr double kTurned_deg = 150;
constexpr size_t kRays = 5'000'000;  // per picture; about ten seconds on one core
constexpr size_t kLeastSamples = 16, kMostSamples = 64;
constexpr int kSampleQuality = 90;
}  // namespace

std::string relit_sample(const RelitScene& scene, const View& view) {
  RelitPainter painter(scene);
  Lighting lighting;
  lighting.environment = scene.captured.rotated(kTurned_deg);
  painter.set_lighting(lighting);
  const size_t pixels = view.intrinsics.pixel_count();
  const auto samples = static_cast<int>(std::clamp(kRays / std::max<size_t>(pixels, 1), kLeastSamples, kMostSamples));
  const RelitPicture picture = painter.picture(view, {.samples = samples});
  return jpeg_bytes(developed(picture.radiance, exposure_of_scene(painter.lit())), kSampleQuality);
}

}  // namespace vitrine
