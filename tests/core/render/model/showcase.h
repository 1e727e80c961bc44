// A case of glass before a camera, and what its panes mirror.
#pragma once

#include <algorithm>
#include <memory>

#include "core/foundation/base/rng.h"
#include "core/scene/shape/shape_set.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/tiny_rooms.h"

namespace vitrine::test {

inline constexpr double kHalf = 0.5, kSheetTolerance = 0.05;  // of the case, a cube about the origin

// A case of glass before a camera that looks into it over a corner; around it and in it large surfels.
struct Showcase {
  SplatScene scene{.diffuse = SplatLayer(LayerKind::Diffuse, 1, 0),
                   .reflection = SplatLayer(LayerKind::Reflection, 1, 0),
                   .transmittance = SplatLayer(LayerKind::Transmittance, 1, 0)};
  View view;
  const Box box{Mat3d::identity(), {-kHalf, -kHalf, -kHalf}, {kHalf, kHalf, kHalf}};
  std::shared_ptr<ShapeSet> set = std::make_shared<ShapeSet>(ShapeSet{{{box, ShapeRole::Sheet, kSheetTolerance, -1, {}}}});
  size_t panes = 0;

  Showcase() {
    const Vec3d eye{1.4, -1.9, 0.8}, z = normalized(-eye), x = normalized(cross(z, Vec3d{0, 0, 1})), y = cross(z, x);
    view.intrinsics = {32, 28, 46, 45, 16.4, 13.7};
    view.cam_from_world.rotation = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
    view.cam_from_world.translation = -(view.cam_from_world.rotation * eye);
    for (size_t f = 0; f < Box::kFaces; ++f) pane(Box::face(f));
    panes = scene.diffuse.size();
    Rng rng(4, 4);
    const auto colour = [&] { return Vec3d{rng.uniform_double(), rng.uniform_double(), rng.uniform_double()}; };
    // Walls, each seen in one pane or another, and something small in the case.
    for (const Vec3d& at : {Vec3d{2.3, 2.4, -1}, {-1.7, -2.8, -1}, {-1.7, 2.3, 1.5}, {1.7, 3.2, -1.3}, {-2.4, -2.5, -1.3}})
      dull(scene.diffuse, {.mean = at, .normal = -at, .size = 1.2, .opacity = 0.8, .rgb = colour()});
    dull(scene.transmittance,
         {.mean = {-0.15, -0.1, -0.1}, .normal = {0.5, -0.8, 0.2}, .size = 0.15, .opacity = 0.95, .rgb = colour()});
    dull(scene.reflection, {.mean = {0, 0, 6}, .normal = {0, 0, -1}, .size = 4, .opacity = 0.9, .rgb = {0.9, 0.6, 0.3}});
    dull(scene.reflection, {.mean = {-3, -4.5, -2}, .normal = {3, 4.5, 2}, .size = 2, .opacity = 0.7, .rgb = {0.3, 0.6, 0.8}});
  }
  void dull(SplatLayer& layer, const RoomSurfel& s) {
    const size_t i = add_surfel(layer, s, layer.size() + 7);
    for (Attribute a : {Attribute::SpecularWeight, Attribute::Transmission})
      if (layer.width(a) > 0) *layer.at(a, i) = logit(1e-4f);
    // The rasteriser has one view direction per surfel, rays have their own.
    std::fill_n(layer.at(Attribute::ShRest, i), layer.width(Attribute::ShRest), 0.f);
  }
  void pane(Box::Face face) {
    const Vec3d n = box.normal(face), u{n.y, n.z, n.x}, v = cross(n, u);
    for (double a : {-0.3, 0.0, 0.3})
      for (double b : {-0.3, 0.0, 0.3}) {
        const size_t i = add_surfel(scene.diffuse, {kHalf * n + a * u + b * v, n, 0.12, 0.97, {0.5, 0.5, 0.5}}, 1);
        for (size_t c = 0; c < 3; ++c) scene.diffuse.at(Attribute::F0, i)[c] = logit(0.06f + 0.01f * float(c));
        *scene.diffuse.at(Attribute::SpecularWeight, i) = logit(0.01f);
        *scene.diffuse.at(Attribute::Transmission, i) = logit(0.97f);
        *scene.diffuse.at(Attribute::Roughness, i) = logit(0.05f);
      }
  }
  ImageOptions options() const {
    ImageOptions o = exact_options();
    o.transmission.glass = Glass::Thin;
    o.shape.set = set;
    return o;
  }
};

}  // namespace vitrine::test
