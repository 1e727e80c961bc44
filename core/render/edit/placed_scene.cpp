#include "core/render/edit/placed_scene.h"

#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "core/render/model/thick_glass.h"

namespace vitrine {

namespace {

constexpr int kDegree = 3, kAzimuths = 8;
constexpr size_t kCoefficients = 16, kSurfelGrain = 1024;
// Nodes and weights of the Gauss-Legendre rule on [-1, 1] (Abramowitz and Stegun, table 25.4).
constexpr std::array<std::array<double, 2>, 4> kHeights{{{-0.8611363115940526, 0.3478548451374538},
                                                         {-0.3399810435848563, 0.6521451548625461},
                                                         {0.3399810435848563, 0.6521451548625461},
                                                         {0.8611363115940526, 0.3478548451374538}}};

bool moves_nothing(const Similarity& s) { return s.scale == 1 && s.rotation == Mat3d::identity() && s.translation == Vec3d{}; }

Quatd times(const Quatd& a, const Quatd& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

Plane placed_shape(Plane s, const Similarity& place) {
  s.centre = place * s.centre, s.axes = place.rotation * s.axes, s.half = place.scale * s.half;
  return s;
}
Box placed_shape(Box s, const Similarity& place) {
  s.axes = place.rotation * s.axes;
  const Vec3d shift = transposed(s.axes) * place.translation;
  s.low = place.scale * s.low + shift, s.high = place.scale * s.high + shift;
  return s;
}
SurfaceOfRevolution placed_shape(SurfaceOfRevolution s, const Similarity& place) {
  s.origin = place * s.origin, s.axis = place.rotation * s.axis;
  for (Vec2d& p : s.profile) p = place.scale * p;
  return s;
}
TriangleShape placed_shape(const TriangleShape& s, const Similarity& place) { return TriangleShape(placed(s.mesh(), place)); }

}  // namespace

ShRotation::ShRotation(const Mat3d& rotation) {
  const Mat3d inverse = transposed(rotation);
  for (const auto& [z, weight] : kHeights)
    for (int k = 0; k < kAzimuths; ++k) {
      const double phi = 2 * std::numbers::pi * k / kAzimuths, r = std::sqrt(1 - z * z);
      const Vec3d d{r * std::cos(phi), r * std::sin(phi), z};
      std::array<double, kCoefficients> here{}, there{};
      sh_basis(kDegree, d, here.data());
      sh_basis(kDegree, inverse * d, there.data());
      const double share = weight * 2 * std::numbers::pi / kAzimuths;
      for (int degree = 1; degree <= kDegree; ++degree)
        for (size_t i = sh_coefficient_count(degree - 1); i < sh_coefficient_count(degree); ++i)
          for (size_t j = sh_coefficient_count(degree - 1); j < sh_coefficient_count(degree); ++j)
            matrix_[i][j] += share * here[i] * there[j];
    }
}

void ShRotation::apply(int degree, float* rest) const {
  std::array<double, 3 * kCoefficients> out{};
  const size_t n = sh_coefficient_count(degree);
  for (size_t i = 1; i < n; ++i)
    for (size_t j = 1; j < n; ++j)
      for (size_t c = 0; c < 3; ++c) out[3 * (i - 1) + c] += matrix_[i][j] * double(rest[3 * (j - 1) + c]);
  for (size_t k = 0; k < 3 * (n - 1); ++k) rest[k] = float(out[k]);
}

SplatLayer placed(SplatLayer layer, const Similarity& place) {
  if (moves_nothing(place)) return layer;
  const bool turns = !(place.rotation == Mat3d::identity());
  const Quatd turn = quaternion(place.rotation);
  const ShRotation harmonics(place.rotation);
  const auto growth = float(std::log(place.scale));
  parallel_for(layer.size(), kSurfelGrain, [&](size_t i) {
    float* mean = layer.at(Attribute::Mean, i);
    const Vec3d p = place * Vec3d{mean[0], mean[1], mean[2]};
    for (size_t c = 0; c < 3; ++c) mean[c] = float(p[c]);
    for (size_t c = 0; c < layer.width(Attribute::LogScale); ++c) layer.at(Attribute::LogScale, i)[c] += growth;
    if (!turns) return;
    float* q = layer.at(Attribute::Rotation, i);
    const Quatd r = times(turn, {q[0], q[1], q[2], q[3]});
    q[0] = float(r.w), q[1] = float(r.x), q[2] = float(r.y), q[3] = float(r.z);
    if (layer.sh_degree() > 0) harmonics.apply(layer.sh_degree(), layer.at(Attribute::ShRest, i));
  });
  return layer;
}

TriMesh placed(TriMesh mesh, const Similarity& place) {
  if (moves_nothing(place)) return mesh;
  for (Vec3f& p : mesh.positions) p = cast<float>(place * cast<double>(p));
  for (Vec3f& n : mesh.normals) n = cast<float>(place.rotation * cast<double>(n));
  return mesh;
}

Shape placed(const Shape& shape, const Similarity& place) {
  return std::visit([&](const auto& s) -> Shape { return placed_shape(s, place); }, shape);
}

ShapeSet placed(ShapeSet set, const Similarity& place) {
  if (moves_nothing(place)) return set;
  for (ShapeSet::Entry& e : set.entries) e.shape = placed(e.shape, place), e.tolerance *= place.scale;
  return set;
}

EditScene placed(EditScene scene, const Similarity& place) {
  if (moves_nothing(place)) return scene;
  SplatScene& surfels = scene.trained.surfels;
  for (SplatLayer* layer : {&surfels.diffuse, &surfels.reflection, &surfels.transmittance, &surfels.opaque})
    *layer = placed(std::move(*layer), place);
  for (TriMesh* mesh : {&scene.mesh, &scene.surroundings, &scene.content}) *mesh = placed(std::move(*mesh), place);
  if (scene.materials) {
    for (Vec3f& length : scene.materials->scatter) length = float(place.scale) * length;
    for (Vec3f& mark : scene.materials->marks) mark = cast<float>(place.rotation * cast<double>(mark));
  }
  ImageOptions& image = scene.trained.image;
  if (image.shape.set) image.shape.set = std::make_shared<const ShapeSet>(placed(*image.shape.set, place));
  if (const ThickGlass* glass = image.transmission.thick.get())
    image.transmission.thick =
        std::make_shared<const ThickGlass>(placed(glass->mesh(), place), glass->ior(), float(place.scale) * glass->tolerance());
  return scene;
}

}  // namespace vitrine
