// Spheres as meshes and as surfels, and cameras that look at them.
#pragma once

#include <cmath>
#include <numbers>

#include "core/foundation/math/rigid.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"

namespace vitrine::test {

// Camera at `centre` looking at `target`, world up = +z.
inline Rigid looking_at(const Vec3d& centre, const Vec3d& target) {
  const Vec3d forward = normalized(target - centre), right = normalized(cross(forward, Vec3d{0, 0, 1})),
              down = cross(forward, right);
  const Mat3d world_from_cam{right, down, forward};
  return inverse(Rigid{world_from_cam, centre});
}

// Latitude-longitude sphere, faces counter-clockwise from outside.
inline TriMesh sphere_mesh(double radius, const Vec3d& centre = {}, uint32_t rings = 24, uint32_t sectors = 48) {
  TriMesh m;
  for (uint32_t r = 0; r <= rings; ++r)
    for (uint32_t s = 0; s < sectors; ++s) {
      const double t = std::numbers::pi * r / rings, p = 2 * std::numbers::pi * s / sectors;
      const Vec3d n{std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
      const Vec3d x = centre + radius * n;
      m.positions.push_back({float(x.x), float(x.y), float(x.z)});
    }
  for (uint32_t r = 0; r < rings; ++r)
    for (uint32_t s = 0; s < sectors; ++s) {
      const uint32_t a = r * sectors + s, b = r * sectors + (s + 1) % sectors, c = a + sectors, d = b + sectors;
      if (r > 0) m.faces.push_back({a, c, b});
      if (r + 1 < rings) m.faces.push_back({b, c, d});
    }
  return m;
}

// Surfels spread over a sphere, coloured by place; they overlap widely, so that the far side does not shine through.
inline SplatLayer sphere_layer(double radius, size_t n = 1800) {
  SplatLayer layer(LayerKind::Diffuse, 0, n);
  for (size_t i = 0; i < n; ++i) {
    const double z = 1 - 2 * (double(i) + 0.5) / double(n), phi = double(i) * std::numbers::pi * (3 - std::sqrt(5.0));
    const double rho = std::sqrt(1 - z * z);
    const Vec3d normal{rho * std::cos(phi), rho * std::sin(phi), z};
    const Vec3d tangent = normalized(cross(normal, std::abs(z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}));
    const Quatd q = quaternion(Mat3d{tangent, cross(normal, tangent), normal});
    const float rotation[] = {float(q.w), float(q.x), float(q.y), float(q.z)};
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = float(radius * normal[c]);
      layer.at(Attribute::ShDc, i)[c] = float((0.35 + 0.3 * normal[c] - 0.5) / kShDc);
    }
    for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = rotation[c];
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = float(std::log(radius * 3.0 / std::sqrt(double(n))));
    *layer.at(Attribute::Opacity, i) = 4;
  }
  return layer;
}

}  // namespace vitrine::test
