// A ball of surfels with a mesh, ready to be relit.
#pragma once

#include "core/render/relight/relit_painter.h"
#include "tests/support/tiny_capture.h"

namespace vitrine::test {

inline RelitScene relit_ball(const Vec3f& albedo, double radius = 0.4) {
  RelitScene s;
  s.trained.surfels.diffuse = sphere_layer(radius);
  s.materials.resize(s.trained.surfels.diffuse.size());
  std::ranges::fill(s.materials.albedo, albedo);
  std::ranges::fill(s.materials.roughness, 0.5f);
  std::ranges::fill(s.materials.f0, Vec3f{0.04f, 0.04f, 0.04f});
  s.captured = Environment(ImageF(8, 4, 3, 1.f));
  s.mesh = sphere_mesh(radius);
  return s;
}

inline View view_from(const Vec3d& eye, int width = 48, int height = 36) {
  View v;
  v.intrinsics = {width, height, 1.1 * width, 1.1 * width, width / 2.0, height / 2.0};
  v.cam_from_world = looking_at(eye, {0, 0, 0});
  return v;
}

inline Lighting constant_light(float radiance) {
  Lighting l;
  l.environment = Environment(ImageF(16, 8, 3, radiance));
  return l;
}

// A painted ball inside a ball of clear glass, trained under a constant light of 1.
inline RelitScene ball_in_glass(Glass glass) {
  RelitScene s = relit_ball({0.1f, 0.1f, 0.1f});
  std::ranges::fill(s.materials.transmission, 1.f);
  std::ranges::fill(s.materials.f0, Vec3f{});
  const SplatLayer inside = sphere_layer(0.2);
  SplatLayer& layer = s.trained.surfels.transmittance;
  layer = SplatLayer(LayerKind::Transmittance, 0, inside.size());
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
    std::ranges::copy(inside.values(a), layer.values(a).begin());
  // What of the diffuse layer is glass is as trained.
  std::ranges::fill(s.trained.surfels.diffuse.values(Attribute::Transmission), 6.f);
  s.trained.image.transmission.glass = glass;
  return s;
}

}  // namespace vitrine::test
