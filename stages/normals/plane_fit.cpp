#include "stages/normals/geometric.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace vitrine {

namespace {

struct Window {
  int radius, stride;
};
constexpr Window kWindows[] = {{4, 1}, {8, 2}, {14, 3}};  // the next one if the previous had too few depths
constexpr double kFewest = 8;                             // minimum sum of weights for a fit
constexpr float kLumaReach = 0.08f;
constexpr double kReach[] = {0.15, 0.05, 0.02, 0.01};  // relative inverse depth: tolerance for the same surface, per round
constexpr double kDepthNoise = 0.004;                  // relative; errors of neighbours are correlated
constexpr double kSureTilt = 0.15;                     // radians of uncertainty that halve the confidence

struct Fit {
  double a, b, c;  // 1/z at pixel offsets from the centre
  double tilt;     // standard deviation of the normal, radians
};

// Inverse of a symmetric 3x3 matrix by Cramer's rule; nullopt when it is singular.
std::optional<Mat3d> inverted(const Mat3d& m) {
  const Vec3d r0 = cross(m.c1, m.c2), r1 = cross(m.c2, m.c0), r2 = cross(m.c0, m.c1);
  const double det = dot(m.c0, r0);
  if (!(std::abs(det) > 1e-12)) return std::nullopt;
  return transposed(Mat3d{r0 / det, r1 / det, r2 / det});
}

class Fitter {
 public:
  Fitter(const DepthSamples& depth, const ImageF& luma, const Intrinsics& k) : depth_(depth), luma_(luma), k_(k) {}

  // `trust_own`: the pixel's own depth selects the surface until there is a fit.
  std::optional<Fit> at(int x, int y, const Window& window, bool trust_own) const {
    const size_t centre = index(x, y);
    std::optional<Fit> fit;
    for (double reach : kReach) {
      const double own = trust_own && depth_.weight[centre] > 0 ? double(depth_.inverse_z[centre]) : 0;
      Mat3d m{};
      Vec3d right{};
      double weights = 0, squares = 0;
      for (int dy = -window.radius; dy <= window.radius; dy += window.stride)
        for (int dx = -window.radius; dx <= window.radius; dx += window.stride) {
          const int u = x + dx, v = y + dy;
          if (u < 0 || v < 0 || u >= depth_.width || v >= depth_.height) continue;
          const size_t i = index(u, v);
          if (!(depth_.weight[i] > 0)) continue;
          const double w = double(depth_.inverse_z[i]);
          const double edge = double((luma_.data()[i] - luma_.data()[centre]) / kLumaReach);
          const double far = double(dx * dx + dy * dy) / (window.radius * window.radius);
          double weight = double(depth_.weight[i]) * (1 - 0.5 * far / 2) / (1 + edge * edge);
          const double expected = fit ? fit->a * dx + fit->b * dy + fit->c : own;
          if (expected > 0) {
            const double off = (w / expected - 1) / reach;
            weight /= (1 + off * off) * (1 + off * off);
            squares += weight * (w / expected - 1) * (w / expected - 1);
          }
          weights += weight;
          const Vec3d p{double(dx), double(dy), 1};
          m.c0 += (weight * p.x) * p;
          m.c1 += (weight * p.y) * p;
          m.c2 += weight * p;
          right += (weight * w) * p;
        }
      if (weights < kFewest) return std::nullopt;
      const auto inverse = inverted(m);
      if (!inverse) return std::nullopt;
      const Vec3d solution = *inverse * right;
      if (!(solution.z > 0)) return std::nullopt;
      const double noise = std::max(kDepthNoise, std::sqrt(squares / weights)) * solution.z;
      const double sa = noise * k_.fx * std::sqrt(std::max(0.0, (*inverse)(0, 0)));
      const double sb = noise * k_.fy * std::sqrt(std::max(0.0, (*inverse)(1, 1)));
      fit = Fit{solution.x, solution.y, solution.z, std::hypot(sa, sb) / solution.z};
    }
    return fit;
  }

 private:
  size_t index(int x, int y) const { return size_t(y) * size_t(depth_.width) + size_t(x); }
  const DepthSamples& depth_;
  const ImageF& luma_;
  const Intrinsics& k_;
};

}  // namespace

NormalMap fitted_normals(const DepthSamples& depth, const ImageF& luma, const Intrinsics& k) {
  NormalMap map(depth.width, depth.height);
  const Fitter fitter(depth, luma, k);
  const auto first_fit = [&](int x, int y) {
    for (bool trust_own : {true, false})
      for (const Window& window : kWindows)
        if (const auto fit = fitter.at(x, y, window, trust_own)) return fit;
    return std::optional<Fit>();
  };
  for (int y = 0; y < depth.height; ++y)
    for (int x = 0; x < depth.width; ++x) {
      const auto fit = first_fit(x, y);
      if (!fit) continue;
      const double px = x + 0.5 - k.cx, py = y + 0.5 - k.cy;
      const Vec3d n{k.fx * fit->a, k.fy * fit->b, fit->c - fit->a * px - fit->b * py};
      const double spread = fit->tilt / kSureTilt;
      map.set(x, y, cast<float>(-normalized(n)), float(1 / (1 + spread * spread)));
    }
  return map;
}

}  // namespace vitrine
