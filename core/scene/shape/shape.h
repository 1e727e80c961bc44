// Parametric shapes with one interface for all kinds (algorithms 9; after `shapes.h` of Pharr, Jakob and Humphreys, "Physically
// Based Rendering", 2023, and the shapes of Mitsuba 3). They replace surfels where the geometry is known better. Lengths in
// scene units, angles in radians.
//
// Training updates a shape by an increment of its parameters, 0 at the current state: grad = dL/dparameters, moved(shape, -rate
// * grad). Shapes are value types; copies are cheap.
#pragma once

#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "core/scene/shape/box.h"
#include "core/scene/shape/hit.h"
#include "core/scene/shape/plane.h"
#include "core/scene/shape/surface_of_revolution.h"
#include "core/scene/shape/triangle_shape.h"

namespace vitrine {

using Shape = std::variant<Plane, Box, SurfaceOfRevolution, TriangleShape>;  // shape_file.h: a row for each

// First hit of a ray that starts outside.
inline std::optional<ShapeHit> intersect(const Shape& shape, const Ray& ray) {
  return std::visit([&](const auto& s) { return s.intersect(ray); }, shape);
}
inline ShapePoint nearest(const Shape& shape, const Vec3d& p) {
  return std::visit([&](const auto& s) { return s.nearest(p); }, shape);
}
// Points whose convex hull is within 1 % of the shape.
inline std::vector<Vec3d> outer_points(const Shape& shape) {
  return std::visit([](const auto& s) { return s.outer_points(); }, shape);
}
// Surface mesh, faces counter-clockwise seen from outside. On curved shapes edges are at most `spacing` long.
inline TriMesh tessellated(const Shape& shape, double spacing) {
  return std::visit([&](const auto& s) { return s.tessellated(spacing); }, shape);
}
// Bounding box, enlarged by `margin`.
inline Bounds3 bounds(const Shape& shape, double margin = 0) {
  Bounds3 out;
  for (const Vec3d& p : outer_points(shape)) out.extend(p);
  out.low -= Vec3d{margin, margin, margin}, out.high += Vec3d{margin, margin, margin};
  return out;
}
// Characteristic length: longest side or largest radius.
inline double size_of(const Shape& shape) {
  return std::visit([](const auto& s) { return s.size(); }, shape);
}
// Planes of the surface, by element; empty for curved shapes.
inline std::vector<Facet> facets(const Shape& shape) {
  return std::visit([](const auto& s) { return s.facets(); }, shape);
}

inline std::vector<ParameterGroup> parameter_groups(const Shape& shape) {
  return std::visit([](const auto& s) { return s.parameters(); }, shape);
}
inline size_t parameter_count(const Shape& shape) {
  size_t count = 0;
  for (const ParameterGroup& g : parameter_groups(shape)) count += g.count;
  return count;
}
// Backpropagates the gradient on t and normal of a hit to the parameters; adds to `out`.
inline void hit_vjp(const Shape& shape, const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) {
  std::visit([&](const auto& s) { s.hit_vjp(ray, hit, grad, out); }, shape);
}
// Backpropagates the gradient on a point attached to the surface. `place` is near the hit and in its element.
inline void place_vjp(const Shape& shape, const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) {
  std::visit([&](const auto& s) { s.place_vjp(hit, place, grad, out); }, shape);
}
// Smooths a gradient over neighbouring parameters to keep the surface smooth.
inline void smooth(const Shape& shape, std::span<double> grad) {
  std::visit([&](const auto& s) { s.smooth(grad); }, shape);
}
inline Shape moved(const Shape& shape, std::span<const double> step) {
  return std::visit([&](const auto& s) -> Shape { return s.moved(step); }, shape);
}

}  // namespace vitrine
