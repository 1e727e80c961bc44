#include "core/scene/shape/shape_file.h"

#include <array>
#include <cmath>

#include "core/foundation/base/json.h"

namespace vitrine {

namespace {

using Out = nlohmann::ordered_json;
using In = nlohmann::json;

constexpr double kSloppy = 1e-4;  // tolerance for unit vectors in files

Out numbers(const Vec3d& v) { return {v.x, v.y, v.z}; }
Out numbers(const Mat3d& m) { return {numbers(m.c0), numbers(m.c1), numbers(m.c2)}; }
Vec3d vec(const In& json) {
  const auto v = json.get<std::array<double, 3>>();
  return {v[0], v[1], v[2]};
}
Mat3d axes(const In& json) { return {vec(json.at(0)), vec(json.at(1)), vec(json.at(2))}; }
bool finite(const Vec3d& v) { return std::isfinite(v.x + v.y + v.z); }
bool unit(const Vec3d& v) { return std::abs(length(v) - 1) < kSloppy; }
bool right_angled(const Mat3d& m) {
  return unit(m.c0) && unit(m.c1) && std::abs(dot(m.c0, m.c1)) < kSloppy && length(cross(m.c0, m.c1) - m.c2) < kSloppy;
}

double number(Rng& rng, double low, double high) { return low + (high - low) * rng.uniform_double(); }
Vec3d vector(Rng& rng) { return {number(rng, -1, 1), number(rng, -1, 1), number(rng, -1, 1)}; }
Mat3d frame(Rng& rng) {
  return rotation_matrix(normalized(Quatd{number(rng, 0.1, 1), number(rng, -1, 1), number(rng, -1, 1), number(rng, -1, 1)}));
}

const TriMesh* no_mesh(const Shape&) { return nullptr; }

Out write_plane(const Shape& shape) {
  const auto& s = std::get<Plane>(shape);
  return {{"centre", numbers(s.centre)}, {"axes", numbers(s.axes)}, {"half", {s.half.x, s.half.y}}};
}
std::optional<Shape> read_plane(const In& json, TriMesh) {
  const auto half = json.at("half").get<std::array<double, 2>>();
  const Plane s{vec(json.at("centre")), axes(json.at("axes")), {half[0], half[1]}};
  const bool right =
      finite(s.centre) && right_angled(s.axes) && s.half.x > 0 && s.half.y > 0 && std::isfinite(s.half.x + s.half.y);
  return right ? std::optional<Shape>(s) : std::nullopt;
}
Shape sample_plane(Rng& rng) { return Plane{0.2 * vector(rng), frame(rng), {number(rng, 0.3, 0.6), number(rng, 0.3, 0.6)}}; }

Out write_box(const Shape& shape) {
  const auto& s = std::get<Box>(shape);
  return {{"axes", numbers(s.axes)}, {"low", numbers(s.low)}, {"high", numbers(s.high)}};
}
std::optional<Shape> read_box(const In& json, TriMesh) {
  const Box s{axes(json.at("axes")), vec(json.at("low")), vec(json.at("high"))};
  bool right = finite(s.low) && finite(s.high) && right_angled(s.axes);
  for (size_t i = 0; i < 3; ++i) right &= s.low[i] < s.high[i];
  return right ? std::optional<Shape>(s) : std::nullopt;
}
Shape sample_box(Rng& rng) {
  const Vec3d half{number(rng, 0.2, 0.5), number(rng, 0.2, 0.5), number(rng, 0.2, 0.5)}, at = 0.2 * vector(rng);
  return Box{frame(rng), at - half, at + half};
}

Out write_revolution(const Shape& shape) {
  const auto& s = std::get<SurfaceOfRevolution>(shape);
  Out profile = Out::array();
  for (const Vec2d& p : s.profile) profile.push_back({p.x, p.y});
  return {{"origin", numbers(s.origin)}, {"axis", numbers(s.axis)}, {"profile", profile}};
}
std::optional<Shape> read_revolution(const In& json, TriMesh) {
  SurfaceOfRevolution s{vec(json.at("origin")), vec(json.at("axis")), {}};
  bool right = finite(s.origin) && unit(s.axis);
  for (const auto& [radius, height] : json.at("profile").get<std::vector<std::array<double, 2>>>()) {
    right &= radius >= 0 && std::isfinite(radius) && std::isfinite(height);
    s.profile.push_back({radius, height});
  }
  return right && s.profile.size() >= 2 ? std::optional<Shape>(std::move(s)) : std::nullopt;
}
// Has a flat foot, a waist and a lid: every kind of segment.
Shape sample_revolution(Rng& rng) {
  const double waist = number(rng, 0.05, 0.12), turns = number(rng, 4, 8);
  SurfaceOfRevolution s{0.2 * vector(rng), normalized(vector(rng) + Vec3d{0, 0, 1.5}), {{0, -0.4}, {0.3, -0.4}}};
  for (int i = 1; i <= 20; ++i) s.profile.push_back({0.3 + waist * std::sin(turns * 0.04 * i), -0.4 + 0.04 * i});
  s.profile.push_back({0.2, 0.4});
  s.profile.push_back({0, 0.45});
  return s;
}

Out write_triangles(const Shape&) { return Out::object(); }
const TriMesh* mesh_of(const Shape& shape) { return &std::get<TriangleShape>(shape).mesh(); }
std::optional<Shape> read_triangles(const In&, TriMesh mesh) {
  if (mesh.faces.empty()) return std::nullopt;
  for (const auto& f : mesh.faces)
    for (const uint32_t v : f)
      if (v >= mesh.positions.size()) return std::nullopt;
  for (const Vec3f& p : mesh.positions)
    if (!finite(cast<double>(p))) return std::nullopt;
  return TriangleShape(std::move(mesh));
}
// Bumpy ball on a longitude-latitude grid.
Shape sample_triangles(Rng& rng) {
  constexpr uint32_t kAround = 40, kUp = 20;
  const Vec3d centre = 0.2 * vector(rng), wave = 3. * vector(rng);
  TriMesh mesh;
  const auto add = [&](double up, double around) {
    const Vec3d n{std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up)};
    mesh.positions.push_back(cast<float>(centre + (0.4 + 0.04 * std::sin(dot(wave, n))) * n));
  };
  add(-M_PI / 2, 0);
  for (uint32_t j = 1; j < kUp; ++j)
    for (uint32_t i = 0; i < kAround; ++i) add(M_PI * (double(j) / kUp - 0.5), 2 * M_PI * i / kAround);
  add(M_PI / 2, 0);
  const auto at = [](uint32_t i, uint32_t j) { return 1 + (j - 1) * kAround + i % kAround; };
  for (uint32_t i = 0; i < kAround; ++i) {
    mesh.faces.push_back({0, at(i + 1, 1), at(i, 1)});
    mesh.faces.push_back({at(0, kUp), at(i, kUp - 1), at(i + 1, kUp - 1)});
    for (uint32_t j = 1; j + 1 < kUp; ++j) {
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return TriangleShape(std::move(mesh));
}

constexpr double kDouble = 1e-10, kSingle = 1e-5;

constexpr std::array<ShapeKind, std::variant_size_v<Shape>> kKinds{{
    {"plane", write_plane, no_mesh, read_plane, sample_plane, kDouble, 0},
    {"box", write_box, no_mesh, read_box, sample_box, kDouble, 0},
    {"surface_of_revolution", write_revolution, no_mesh, read_revolution, sample_revolution, kDouble, 0},
    {"triangles", write_triangles, mesh_of, read_triangles, sample_triangles, kSingle, 0.2},
}};

}  // namespace

std::span<const ShapeKind> shape_kinds() { return kKinds; }

const ShapeKind* find_shape_kind(std::string_view name) {
  for (const ShapeKind& kind : kKinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

}  // namespace vitrine
