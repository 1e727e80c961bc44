#include "core/scene/shape/shape_set.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {
constexpr double kAlike = 0.9, kBulge = 0.5;  // cosine of the normals; height over the parent, relative to the tolerance
}

bool ShapeSet::is_bulge(const Hit& appendage, const Hit& parent, const Ray& ray) const {
  const double height = (parent.t - appendage.t) * length(ray.direction);
  return dot(parent.normal, appendage.normal) > kAlike && height < kBulge * entries[appendage.entry].tolerance;
}

bool ShapeSet::has(ShapeRole role) const {
  return std::ranges::any_of(entries, [&](const Entry& e) { return e.role == role; });
}

uint32_t ShapeSet::root(uint32_t entry) const {
  while (entries[entry].parent >= 0) entry = static_cast<uint32_t>(entries[entry].parent);
  return entry;
}

ShapeSet ShapeSet::kept(std::span<const uint8_t> keep) const {
  ShapeSet out;
  std::vector<int> place(entries.size(), -1);  // index in the result
  for (size_t i = 0; i < entries.size(); ++i) {
    const int parent = entries[i].parent;
    if (!keep[i] || (parent >= 0 && place[static_cast<size_t>(parent)] < 0)) continue;
    place[i] = static_cast<int>(out.entries.size());
    Entry& entry = out.entries.emplace_back(entries[i]);
    if (parent >= 0) entry.parent = place[static_cast<size_t>(parent)];
  }
  return out;
}

bool ShapeSet::has_glass() const {
  return std::ranges::any_of(entries, [](const Entry& e) { return is_glass(e.role); });
}

ShapeSet ShapeSet::kept_roles(bool (*keeps)(ShapeRole)) const {
  std::vector<uint8_t> keep;
  for (const Entry& e : entries) keep.push_back(keeps(e.role));
  return kept(keep);
}

ShapeSet ShapeSet::without(ShapeRole role) const {
  std::vector<uint8_t> keep;
  for (const Entry& e : entries) keep.push_back(e.role != role);
  return kept(keep);
}

ShapeSet ShapeSet::glass() const { return kept_roles(is_glass); }
ShapeSet ShapeSet::no_glass() const {
  return kept_roles([](ShapeRole role) { return !is_glass(role); });
}

void ShapeSet::append(ShapeSet more) {
  const auto first = static_cast<int>(entries.size());
  for (Entry& e : more.entries) {
    if (e.parent >= 0) e.parent += first;
    entries.push_back(std::move(e));
  }
}

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
