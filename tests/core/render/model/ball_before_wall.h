// A polished ball of blurry surfels before a wall, and something for it to mirror.
#pragma once

#include <cmath>
#include <initializer_list>
#include <memory>
#include <numbers>

#include "core/scene/shape/shape_set.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/tiny_rooms.h"

namespace vitrine {

inline ShapeSet set_of(std::initializer_list<Shape> shapes) {
  ShapeSet set;
  for (const Shape& s : shapes) set.entries.push_back({s, ShapeRole::Mirror, 0.06 * size_of(s), -1, {}});
  return set;
}

struct BallBeforeWall {
  LayeredRoom room;
  std::shared_ptr<ShapeSet> set = std::make_shared<ShapeSet>();
  ImageOptions options = exact_options();
  size_t of_ball = 0;  // surfels, the first ones; the wall follows
  static constexpr double kRadius = 0.35;
  Vec3d centre{0.02, -0.03, 2};

  BallBeforeWall() {
    room.view.intrinsics = {32, 32, 60, 60, 16.2, 15.7};
    room.scene.diffuse = SplatLayer(LayerKind::Diffuse, 1, 0);
    room.scene.reflection = SplatLayer(LayerKind::Reflection, 1, 0);
    room.scene.transmittance = SplatLayer(LayerKind::Transmittance, 1, 0);
    SurfaceOfRevolution s{centre, normalized(Vec3d{0.1, 1, 0.3}), {}};
    for (size_t i = 0; i <= 60; ++i) {
      const double a = std::numbers::pi * (double(i) / 60 - 0.5);
      s.profile.push_back({i == 0 || i == 60 ? 0 : kRadius * std::cos(a), kRadius * std::sin(a)});
    }
    *set = set_of({s});
    options.shape.set = set;
    SplatLayer& d = room.scene.diffuse;
    const auto material = [&](size_t i, double specular, double f0) {
      for (size_t c = 0; c < 3; ++c) d.at(Attribute::F0, i)[c] = float(logit(f0 + 0.02 * double(c)));
      *d.at(Attribute::Roughness, i) = float(logit(0.3));
      *d.at(Attribute::SpecularWeight, i) = float(logit(specular));
      *d.at(Attribute::Transmission, i) = float(logit(0.001));
    };
    constexpr size_t kSurfels = 60;
    for (size_t k = 0; k < kSurfels; ++k) {
      const double y = 1 - 2 * (double(k) + 0.5) / kSurfels, a = 2.39996 * double(k), r = std::sqrt(1 - y * y);
      const Vec3d n{r * std::cos(a), y, r * std::sin(a)};
      material(
          add_surfel(d, {.mean = centre + kRadius * n, .normal = n, .size = 0.09, .opacity = 0.97, .rgb = {0.3, 0.2, 0.1}}, k),
          0.8, 0.6);
    }
    of_ball = d.size();
    material(add_surfel(d, {.mean = {0, 0, 4}, .normal = {0.1, 0, -1}, .size = 3, .opacity = 0.95, .rgb = {0.1, 0.5, 0.9}}, 77),
             0.001, 0.04);
    for (uint64_t k = 0; k < 4; ++k)
      add_surfel(room.scene.reflection,
                 {.mean = Vec3d{2.0 * double(k) - 3, 1.5 - double(k), -2 - 0.3 * double(k)},
                  .normal = {0, 0.1, 1},
                  .size = 3,
                  .opacity = 0.6,
                  .rgb = {0.2 * double(k), 0.8, 0.3}},
                 90 + k);
  }
  bool is_ball(size_t i) const { return i < of_ball; }
};

}  // namespace vitrine
