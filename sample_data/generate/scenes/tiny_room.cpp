// A room for tests: 2.4 m wide, open at the top, everything opaque and painted so coarsely (patches of 10 cm and more) that
// pictures of 96x64 pixels resolve it. A small lamp hangs in it beside the sky.
#include <algorithm>
#include <cmath>

#include "sample_data/generate/scenes/patches.h"
#include "sample_data/generate/scenes/scenes.h"

namespace vitrine::generate {
namespace {

void add(Scene& scene, const char* name, Shape shape, Texture albedo, bool object) {
  scene.parts.push_back(
      {.name = name, .shape = std::move(shape), .material = {.albedo = std::move(albedo)}, .object = object, .measured = true});
}

Scene painted_walls() {
  constexpr float kHalf = 1.2f, kHeight = 1.5f, kCell = 0.04f;
  Scene scene;
  const Vec3f a{-kHalf, -kHalf, 0}, b{kHalf, -kHalf, 0}, c{kHalf, kHalf, 0}, d{-kHalf, kHalf, 0}, up{0, 0, kHeight};
  add(scene, "floor", rectangle(a, b - a, d - a, kCell), patches({0.80f, 0.72f, 0.60f}, 0.20f, 1), false);
  add(scene, "wall_south", rectangle(b, a - b, up, kCell), patches({0.85f, 0.55f, 0.45f}, 0.30f, 2), false);
  add(scene, "wall_east", rectangle(c, b - c, up, kCell), patches({0.50f, 0.75f, 0.85f}, 0.30f, 3), false);
  add(scene, "wall_north", rectangle(d, c - d, up, kCell), patches({0.80f, 0.80f, 0.50f}, 0.30f, 4), false);
  add(scene, "wall_west", rectangle(a, d - a, up, kCell), patches({0.60f, 0.85f, 0.60f}, 0.30f, 5), false);
  return scene;
}

void add_light(Scene& scene) {
  add_lamp(scene, {{-0.25f, -0.15f, 1.95f}, {0, 0.3f, 0}, {0.5f, 0, 0}, {9.0f, 7.8f, 6.0f}});
  scene.environment = painted_environment(64, noon_sky, 2.0f);
  scene.others.push_back({"studio", painted_environment(64, studio_lights, 1.6f)});
  scene.probes = {{0, 0, 0.1f},    {0.9f, 0.9f, 0.4f}, {-0.9f, 0.9f, 0.4f}, {0.9f, -0.9f, 0.4f}, {-0.9f, -0.9f, 0.4f},
                  {1.1f, 0, 1.3f}, {-1.1f, 0, 1.3f},   {0, 1.1f, 1.3f},     {0, -1.1f, 1.3f}};
  scene.sensor = {.extension = ".png"};
}

}  // namespace

Scene tiny_room() {
  Scene scene = painted_walls();
  add(scene, "crate", turned_box({-0.28f, 0.12f, 0.16f}, {0.32f, 0.32f, 0.32f}, 0.5f, 0.02f),
      patches({0.95f, 0.75f, 0.40f}, 0.13f, 6), true);
  add(scene, "slab", turned_box({0.22f, -0.32f, 0.06f}, {0.50f, 0.30f, 0.12f}, -0.35f, 0.02f),
      patches({0.55f, 0.55f, 0.95f}, 0.12f, 7), true);
  const Bounds3 ball{{0.04, 0.04, -0.02}, {0.56, 0.56, 0.54}};
  add(scene, "ball",
      meshed(
          [](const Vec3f& p) {
            return length(p - Vec3f{0.30f, 0.30f, 0.24f}) - 0.24f;
          },
          ball, 0.02f),
      patches({0.95f, 0.60f, 0.60f}, 0.14f, 8), true);
  const Bounds3 ring{{-0.58, -0.54, -0.02}, {-0.06, -0.18, 0.50}};
  add(scene, "ring",
      meshed(
          [](const Vec3f& p) {
            return torus_distance(p, {-0.32f, -0.36f, 0.24f}, normalized(Vec3f{0.3f, 1, 0}), 0.16f, 0.07f);
          },
          ring, 0.02f),
      patches({0.70f, 0.95f, 0.75f}, 0.12f, 9), true);

  add_light(scene);
  scene.samples = 32;
  scene.full_truth = true;
  scene.relit_every = scene.transmitted_every = 1;
  const Intrinsics camera{96, 64, 78.0, 78.0, 48.7, 31.4};
  add_ring(scene, {.count = 6, .azimuth_rad = 0.2, .elevation_rad = 0.42, .distance = 1.22, .sway = 0.04}, {0, 0, 0.18}, camera);
  add_ring(scene, {.count = 6, .azimuth_rad = 0.7, .elevation_rad = 0.80, .distance = 1.25, .sway = 0.04}, {0, 0, 0.15}, camera);
  return scene;
}

Scene paperweight() {
  Scene scene = painted_walls();
  add(scene, "stand", box({-0.16f, -0.16f, 0}, {0.16f, 0.16f, 0.06f}, 0.02f), patches({0.95f, 0.75f, 0.40f}, 0.08f, 6), false);
  const Vec3f centre{0, 0, 0.30f};
  const float radius = 0.25f;
  const Bounds3 around{{-0.28, -0.28, 0.02}, {0.28, 0.28, 0.58}};
  scene.parts.push_back({.name = "ball",
                         .shape = meshed([=](const Vec3f& p) { return length(p - centre) - radius; }, around, 0.01f),
                         .material = {.kind = MaterialKind::SolidGlass},
                         .object = true,
                         .measured = true});
  add_light(scene);
  const Intrinsics camera{160, 120, 130.0, 130.0, 80.6, 59.3};
  for (const double elevation : {0.15, 0.45, 0.8})
    add_ring(scene, {.count = 12, .azimuth_rad = 0.2 + elevation, .elevation_rad = elevation, .distance = 1.08, .sway = 0.04},
             {0, 0, 0.25}, camera);
  return scene;
}

}  // namespace vitrine::generate
