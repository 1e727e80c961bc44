// The ball of solid glass of the painted room, filled: with a cloudy liquid, or with smoke that rises in a spiral.
#include <cmath>
#include <numbers>

#include "core/foundation/base/rng.h"
#include "sample_data/generate/content.h"
#include "sample_data/generate/scenes/scenes.h"

namespace vitrine::generate {
namespace {

Scene filled_ball(GlassContent content) {
  Scene scene = paperweight();
  for (Part& part : scene.parts)
    if (part.material.kind == MaterialKind::SolidGlass) {
      part.material.index_of_refraction = 1.33f;
      part.material.content = std::make_shared<const GlassContent>(std::move(content));
    }
  scene.samples = 32;
  return scene;
}

}  // namespace

Scene cloudy() { return filled_ball({3.5f, {0.22f, 0.30f, 0.14f}, {}}); }

Scene smoky() {
  constexpr int kClouds = 28;
  std::vector<GlassContent::Cloud> clouds;
  for (int i = 0; i < kClouds; ++i) {
    Rng rng(0x50e, uint64_t(i));
    const float up = (float(i) + 0.5f) / kClouds, turn = 1.5f * 2 * std::numbers::pi_v<float> * up;
    const float radius = 0.02f + 0.13f * std::sin(std::numbers::pi_v<float> * up), width = 0.014f + 0.016f * up;
    Gaussian3f g;
    g.mean = {radius * std::cos(turn) + 0.01f * rng.normal(), radius * std::sin(turn) + 0.01f * rng.normal(), 0.12f + 0.36f * up};
    for (size_t c = 0; c < 3; ++c) g.log_scale[c] = std::log(width) + 0.3f * rng.normal();
    g.rotation = {rng.normal(), rng.normal(), rng.normal(), rng.normal()};
    g.log_density = std::log(30.0f) + 0.3f * rng.normal() - 1.2f * up;
    clouds.push_back({g, mixed(Vec3f{0.45f, 0.12f, 0.03f}, Vec3f{0.08f, 0.12f, 0.24f}, up)});
  }
  return filled_ball({0.2f, {0.2f, 0.2f, 0.2f}, std::move(clouds)});
}

}  // namespace vitrine::generate
