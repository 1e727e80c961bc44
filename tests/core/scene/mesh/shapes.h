// Known meshes for the tests: unit cube, sphere, flat grid.
#pragma once

#include <cmath>
#include <numbers>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine::shapes {

// [0,1]^3, 8 vertices, 12 faces, counter-clockwise from outside.
inline TriMesh cube() {
  TriMesh m;
  for (int i = 0; i < 8; ++i) m.positions.push_back({float(i & 1), float((i >> 1) & 1), float(i >> 2)});
  m.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
             {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

// Rings of latitude, closed by two poles.
inline TriMesh sphere(Vec3f centre, float radius, uint32_t rings, uint32_t sectors) {
  TriMesh m;
  const auto add = [&](float theta, float phi) {
    const Vec3f n{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
    m.normals.push_back(n);
    m.positions.push_back(centre + radius * n);
  };
  const float pi = std::numbers::pi_v<float>;
  add(0, 0);
  for (uint32_t r = 1; r < rings; ++r)
    for (uint32_t s = 0; s < sectors; ++s) add(pi * float(r) / float(rings), 2 * pi * float(s) / float(sectors));
  add(pi, 0);
  const uint32_t last = static_cast<uint32_t>(m.positions.size()) - 1;
  const auto id = [&](uint32_t r, uint32_t s) { return r == 0 ? 0 : r == rings ? last : 1 + (r - 1) * sectors + s % sectors; };
  for (uint32_t r = 0; r < rings; ++r)
    for (uint32_t s = 0; s < sectors; ++s) {
      if (r + 1 < rings) m.faces.push_back({id(r, s), id(r + 1, s), id(r + 1, s + 1)});
      if (r > 0) m.faces.push_back({id(r, s), id(r + 1, s + 1), id(r, s + 1)});
    }
  return m;
}

// n x n squares over [0,1]^2 at height z, facing +z.
inline TriMesh grid(uint32_t n, float z = 0) {
  TriMesh m;
  for (uint32_t y = 0; y <= n; ++y)
    for (uint32_t x = 0; x <= n; ++x) m.positions.push_back({float(x) / float(n), float(y) / float(n), z});
  for (uint32_t y = 0; y < n; ++y)
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      m.faces.push_back({a, b, d});
      m.faces.push_back({a, d, c});
    }
  return m;
}

inline void append(TriMesh& to, const TriMesh& mesh) {
  const uint32_t base = static_cast<uint32_t>(to.positions.size());
  to.positions.insert(to.positions.end(), mesh.positions.begin(), mesh.positions.end());
  to.normals.insert(to.normals.end(), mesh.normals.begin(), mesh.normals.end());
  to.colors.insert(to.colors.end(), mesh.colors.begin(), mesh.colors.end());
  for (const auto& f : mesh.faces) to.faces.push_back({f[0] + base, f[1] + base, f[2] + base});
}

}  // namespace vitrine::shapes
