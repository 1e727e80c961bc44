// Triangle shapes of the scenes: flat rectangles and boxes cut into cells (the irradiance cache lives at the vertices, so a
// cell is also the finest indirect shadow), and smooth bodies meshed from a signed distance function.
#pragma once

#include <functional>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine::generate {

struct Shape {
  TriMesh mesh;           // positions, normals, faces; counter-clockwise seen from outside
  std::vector<Vec2f> uv;  // [v] metres
};

void append(TriMesh& to, const TriMesh& from);
void append(Shape& to, const Shape& from);

// Outside is cross(edge_u, edge_v); uv runs along the edges in metres from `corner`.
Shape rectangle(const Vec3f& corner, const Vec3f& edge_u, const Vec3f& edge_v, float cell);
Shape box(const Vec3f& low, const Vec3f& high, float cell);
// A box turned by `angle` (radians) about the vertical through its centre.
Shape turned_box(const Vec3f& centre, const Vec3f& size, float angle, float cell);

using DistanceFunction = std::function<float(const Vec3f&)>;  // negative inside
// Naive surface nets (Gibson 1998) on a grid of `cell`, vertices then projected on the zero set; normals are its gradient.
Shape meshed(const DistanceFunction& distance, const Bounds3& bounds, float cell);

// Distance functions (the ellipsoid's is a bound, good near the surface) and their smooth union (quadratic, radius k).
float ellipsoid_distance(const Vec3f& p, const Vec3f& centre, const Vec3f& radii);
float capsule_distance(const Vec3f& p, const Vec3f& a, const Vec3f& b, float radius_a, float radius_b);
float torus_distance(const Vec3f& p, const Vec3f& centre, const Vec3f& axis, float ring, float tube);
float smooth_union(float a, float b, float k);

}  // namespace vitrine::generate
