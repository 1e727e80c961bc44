#include "core/scene/shape/surface_samples.h"

#include <cmath>

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr double kFirstStep = 0.7548776662466927, kSecondStep = 0.5698402909980532;  // steps of the R2 sequence

Vec3d on_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c, size_t index) {
  double u = std::fmod(0.5 + kFirstStep * double(index), 1.0), v = std::fmod(0.5 + kSecondStep * double(index), 1.0);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return a + u * (b - a) + v * (c - a);
}

}  // namespace

std::vector<ShapePoint> surface_samples(const Shape& shape, double spacing) {
  const TriMesh mesh = tessellated(shape, 2 * spacing);
  std::vector<Vec3d> places;
  double due = 0.5;  // samples owed for the area so far
  for (const auto& f : mesh.faces) {
    const Vec3d a = cast<double>(mesh.positions[f[0]]), b = cast<double>(mesh.positions[f[1]]),
                c = cast<double>(mesh.positions[f[2]]);
    due += 0.5 * length(cross(b - a, c - a)) / (spacing * spacing);
    for (; due >= 1; due -= 1) places.push_back(on_triangle(a, b, c, places.size()));
  }
  std::vector<ShapePoint> points(places.size());
  parallel_for(points.size(), 256, [&](size_t i) { points[i] = nearest(shape, places[i]); });
  return points;
}

}  // namespace vitrine
