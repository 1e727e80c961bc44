// A hall for captures that are split by place: 12 m long, 3 m wide, open at the top, painted like the room of tiny_room.cpp, with
// crates along both walls. Three walks of a hundred photos: along the hall with a view of either wall, and up the middle with a
// view ahead and to the side.
#include <cmath>

#include <fmt/format.h>

#include "sample_data/generate/scenes/patches.h"
#include "sample_data/generate/scenes/scenes.h"

namespace vitrine::generate {
namespace {

constexpr float kLong = 6.f, kWide = 1.5f, kHeight = 1.8f, kCell = 0.08f;
constexpr int kWalk = 100;

void add(Scene& scene, std::string name, Shape shape, Texture albedo, bool object) {
  scene.parts.push_back({.name = std::move(name),
                         .shape = std::move(shape),
                         .material = {.albedo = std::move(albedo)},
                         .object = object,
                         .measured = true});
}

void add_walls(Scene& scene) {
  const Vec3f a{-kLong, -kWide, 0}, b{kLong, -kWide, 0}, c{kLong, kWide, 0}, d{-kLong, kWide, 0}, up{0, 0, kHeight};
  add(scene, "floor", rectangle(a, b - a, d - a, kCell), patches({0.80f, 0.72f, 0.60f}, 0.30f, 1), false);
  add(scene, "wall_south", rectangle(b, a - b, up, kCell), patches({0.85f, 0.55f, 0.45f}, 0.30f, 2), false);
  add(scene, "wall_east", rectangle(c, b - c, up, kCell), patches({0.50f, 0.75f, 0.85f}, 0.30f, 3), false);
  add(scene, "wall_north", rectangle(d, c - d, up, kCell), patches({0.80f, 0.80f, 0.50f}, 0.30f, 4), false);
  add(scene, "wall_west", rectangle(a, d - a, up, kCell), patches({0.60f, 0.85f, 0.60f}, 0.30f, 5), false);
}

void add_crates(Scene& scene) {
  constexpr int kCrates = 12;
  for (int i = 0; i < kCrates; ++i) {
    const float x = -kLong + 2 * kLong * (float(i) + 0.5f) / kCrates, height = 0.3f + 0.1f * float(i % 4);
    const float y = (i % 2 ? 1.f : -1.f) * 1.1f;
    add(scene, fmt::format("crate_{}", i), turned_box({x, y, 0.5f * height}, {0.4f, 0.36f, height}, 0.4f * float(i), 0.03f),
        patches({0.5f + 0.04f * float(i), 0.95f - 0.04f * float(i), 0.6f}, 0.16f, uint32_t(10 + i)), true);
  }
}

// `number`: 0 to kWalk - 1 along the hall. The eye wavers, like that of a person who walks.
View view_on_walk(int walk, int number) {
  const double along = double(number) / (kWalk - 1), x = (2 * along - 1) * (kLong - 0.7);
  const double waver = std::sin(0.9 * number + walk);
  const double forth = 0.35 * std::sin(0.37 * number);
  View view;
  view.name = fmt::format("img_{:04}.png", walk * kWalk + number);
  view.intrinsics = {160, 120, 120.0, 120.0, 80.4, 59.6};
  const double side = walk == 0 ? 1 : walk == 1 ? -1 : (number % 2 ? 0.6 : -0.6);
  const Vec3d eye{x, walk == 2 ? 0.1 * waver : -0.75 * side, 1.15 + 0.1 * waver};
  const Vec3d target = eye + Vec3d{walk == 2 ? (number < kWalk / 2 ? 1.0 : -1.0) : forth, side, -0.4 + 0.1 * waver};
  view.cam_from_world = looking_at(eye, target, {0, 0, 1});
  return view;
}

}  // namespace

Scene hall() {
  Scene scene;
  add_walls(scene);
  add_crates(scene);
  add_lamp(scene, {{-1.f, -0.3f, 2.6f}, {0, 0.6f, 0}, {2.f, 0, 0}, {5.0f, 4.4f, 3.6f}});
  scene.environment = painted_environment(64, noon_sky, 2.0f);
  for (int i = 0; i < 7; ++i) scene.probes.push_back({-5.4f + 1.8f * float(i), 0, 0.6f});
  scene.sensor = {.extension = ".png"};
  scene.samples = 16;
  scene.cache = {.direct_samples = 64, .gather_samples = 32, .passes = 2};
  for (int walk = 0; walk < 3; ++walk)
    for (int number = 0; number < kWalk; ++number) scene.views.push_back(view_on_walk(walk, number));
  return scene;
}

}  // namespace vitrine::generate
