// Surfaces that are known better than surfels tell: one interface for all kinds (algorithms 9; after `shapes.h` of Pharr, Jakob
// and Humphreys, "Physically Based Rendering", 2023, and the shapes of Mitsuba 3). Lengths in scene units, angles in radians.
//
// Training moves a shape by its parameters, numbers that are 0 where it is: grad = dL/dparameters, moved(shape, -rate * grad).
// Shapes are values; copies are cheap.
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

using Shape = std::variant<Plane, Box, SurfaceOfRevolution, TriangleShape>;  // registry.h has a row for each

// Where a ray from outside first meets it.
inline std::optional<ShapeHit> intersect(const Shape& shape, const Ray& ray) {
  return std::visit([&](const auto& s) { return s.intersect(ray); }, shape);
}
inline ShapePoint nearest(const Shape& shape, const Vec3d& p) {
  return std::visit([&](const auto& s) { return s.nearest(p); }, shape);
}
// Points whose convex hull the shape fills but for a hundredth.
inline std::vector<Vec3d> outer_points(const Shape& shape) {
  return std::visit([](const auto& s) { return s.outer_points(); }, shape);
}
// Its surface as a mesh, faces counter-clockwise from outside; of a curved one edges are `spacing` long at most.
inline TriMesh tessellated(const Shape& shape, double spacing) {
  return std::visit([&](const auto& s) { return s.tessellated(spacing); }, shape);
}
// Of the shape, and of all that lies no farther than `margin` from it.
inline Bounds3 bounds(const Shape& shape, double margin = 0) {
  Bounds3 out;
  for (const Vec3d& p : outer_points(shape)) out.extend(p);
  out.low -= Vec3d{margin, margin, margin}, out.high += Vec3d{margin, margin, margin};
  return out;
}
// A length that says how large it is: its longest side, its largest radius.
inline double size_of(const Shape& shape) {
  return std::visit([](const auto& s) { return s.size(); }, shape);
}
// The planes that its surface consists of, by element; none if it is curved.
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
// From a gradient on t and normal of a hit to the parameters, added.
inline void hit_vjp(const Shape& shape, const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) {
  std::visit([&](const auto& s) { s.hit_vjp(ray, hit, grad, out); }, shape);
}
// The same of a gradient on a point that moves with the surface: `place`, near the hit and in its element.
inline void place_vjp(const Shape& shape, const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) {
  std::visit([&](const auto& s) { s.place_vjp(hit, place, grad, out); }, shape);
}
// Mixes a gradient among neighbours, so that a surface bends slowly.
inline void smooth(const Shape& shape, std::span<double> grad) {
  std::visit([&](const auto& s) { s.smooth(grad); }, shape);
}
inline Shape moved(const Shape& shape, std::span<const double> step) {
  return std::visit([&](const auto& s) -> Shape { return s.moved(step); }, shape);
}

}  // namespace vitrine
