#include "stages/export/formats/source.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/math/spherical_harmonics.h"

namespace vitrine {

namespace {

constexpr size_t kMaxCoefficients = 16;
using BandMatrix = std::array<std::array<double, kMaxCoefficients>, kMaxCoefficients>;

// Coefficients of the rotated function: h'_k = sum_j M_kj h_j,  M_kj = integral of Y_k(d) Y_j(A^T d) over the sphere. The
// integrand is a polynomial of degree 6: Gauss-Legendre in z with 8 nodes and 16 azimuths is exact.
BandMatrix turned_bands(const Mat3d& axes, int degree) {
  constexpr std::array<double, 4> kNode{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr std::array<double, 4> kWeight{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  constexpr int kAzimuths = 16;
  const size_t n = sh_coefficient_count(degree);
  BandMatrix m{};
  for (size_t i = 0; i < 8; ++i) {
    const double z = (i < 4 ? 1 : -1) * kNode[i % 4], r = std::sqrt(1 - z * z);
    const double weight = kWeight[i % 4] * 2 * M_PI / kAzimuths;
    for (int a = 0; a < kAzimuths; ++a) {
      const double angle = 2 * M_PI * (a + 0.5) / kAzimuths;
      const Vec3d d{r * std::cos(angle), r * std::sin(angle), z};
      double to[kMaxCoefficients], from[kMaxCoefficients];
      sh_basis(degree, d, to);
      sh_basis(degree, transposed_times(axes, d), from);
      for (size_t k = 0; k < n; ++k)
        for (size_t j = 0; j < n; ++j) m[k][j] += weight * to[k] * from[j];
    }
  }
  return m;
}

}  // namespace

ExportFrame ExportFrame::of(ExportAxes axes, double scale) {
  // Columns: where the scene's x, y and z go.
  if (axes == ExportAxes::Rhzu) return {.scale = scale};
  if (axes == ExportAxes::Rhyu) return {{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, scale};
  if (axes == ExportAxes::Lhzu) return {{{1, 0, 0}, {0, -1, 0}, {0, 0, 1}}, scale};
  return {{{1, 0, 0}, {0, 0, 1}, {0, 1, 0}}, scale};  // Lhyu
}

TriMesh in_frame(const TriMesh& mesh, const ExportFrame& frame) {
  TriMesh out = mesh;
  if (frame.identity()) return out;
  for (Vec3f& p : out.positions) p = frame.point(p);
  for (Vec3f& n : out.normals) n = frame.direction(n);
  if (frame.mirrored())
    for (auto& f : out.faces) std::swap(f[1], f[2]);
  return out;
}

SplatLayer in_frame(const SplatLayer& layer, const ExportFrame& frame) {
  SplatLayer out = layer;
  if (frame.identity()) return out;
  const size_t rest = layer.width(Attribute::ShRest) / 3;
  const BandMatrix bands = turned_bands(frame.axes, layer.sh_degree());
  // Reversing the normal of a mirrored disk gives right-handed axes again.
  const double handed = frame.mirrored() ? -1 : 1;
  for (size_t i = 0; i < out.size(); ++i) {
    float* mean = out.at(Attribute::Mean, i);
    const Vec3f p = frame.point({mean[0], mean[1], mean[2]});
    for (size_t c = 0; c < 3; ++c) mean[c] = p[c];
    float* q = out.at(Attribute::Rotation, i);
    const Mat3d before = rotation_matrix(normalized(Quatd{q[0], q[1], q[2], q[3]}));
    const Mat3d after{frame.axes * before.c0, frame.axes * before.c1, handed * (frame.axes * before.c2)};
    const Quatd turned = quaternion(after);
    q[0] = float(turned.w), q[1] = float(turned.x), q[2] = float(turned.y), q[3] = float(turned.z);
    for (size_t c = 0; c < 2; ++c) out.at(Attribute::LogScale, i)[c] += float(std::log(frame.scale));
    for (size_t k = 0; k < rest; ++k)
      for (size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (size_t j = 0; j < rest; ++j) sum += bands[k + 1][j + 1] * double(layer.at(Attribute::ShRest, i)[3 * j + c]);
        out.at(Attribute::ShRest, i)[3 * k + c] = float(sum);
      }
  }
  return out;
}

}  // namespace vitrine
