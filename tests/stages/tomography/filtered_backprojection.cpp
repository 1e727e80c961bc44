#include "tests/stages/tomography/filtered_backprojection.h"

#include <algorithm>
#include <complex>
#include <numbers>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/median.h"
#include "stages/tomography/voxel_fit.h"

namespace vitrine::test {

namespace {

using Complex = std::complex<double>;

// In place, length a power of two (Cooley and Tukey 1965). `sign`: -1 forward, 1 inverse without the factor 1/n.
void fourier(std::vector<Complex>& a, double sign) {
  const size_t n = a.size();
  for (size_t i = 1, j = 0; i < n; ++i) {
    size_t bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(a[i], a[j]);
  }
  for (size_t len = 2; len <= n; len <<= 1)
    for (size_t k = 0; k < len / 2; ++k) {
      const Complex turn = std::polar(1., sign * 2 * std::numbers::pi * double(k) / double(len));
      for (size_t i = k; i < n; i += len) {
        const Complex even = a[i], odd = turn * a[i + len / 2];
        a[i] = even + odd, a[i + len / 2] = even - odd;
      }
    }
}

// Ramp filter of rows with samples `step` apart, band-limited in space (Kak and Slaney 1988, 3.3): no loss of the mean.
class RampFilter {
 public:
  RampFilter(int width, double step) {
    size_t n = 1;
    while (n < 2 * size_t(width)) n <<= 1;
    transfer_.assign(n, 0);
    transfer_[0] = 1 / (4 * step);
    for (size_t i = 1; i < size_t(width); i += 2)
      transfer_[i] = transfer_[n - i] = -1 / (std::numbers::pi * std::numbers::pi * double(i) * double(i) * step);
    fourier(transfer_, -1);
  }
  void apply(std::vector<double>& row) const {
    std::vector<Complex> a(transfer_.size(), 0);
    std::ranges::copy(row, a.begin());
    fourier(a, -1);
    for (size_t i = 0; i < a.size(); ++i) a[i] *= transfer_[i];
    fourier(a, 1);
    for (size_t i = 0; i < row.size(); ++i) row[i] = a[i].real() / double(a.size());
  }

 private:
  std::vector<Complex> transfer_;
};

ImageF filtered(const ScanGeometry& g, const ImageF& projection, const RampFilter& filter) {
  ImageF out(projection.width(), projection.height(), 1);
  std::vector<double> row(static_cast<size_t>(projection.width()));
  for (int y = 0; y < projection.height(); ++y) {
    const double v = (0.5 * g.height - y - 0.5) * g.pixel_size + g.detector_offset.y;
    for (int x = 0; x < projection.width(); ++x) {
      const double u = (x + 0.5 - 0.5 * g.width) * g.pixel_size + g.detector_offset.x, d = g.detector_distance;
      const double cosine = g.beam == Beam::Cone ? d / std::sqrt(d * d + u * u + v * v) : 1;
      row[size_t(x)] = cosine * double(projection.at(x, y));
    }
    filter.apply(row);
    for (int x = 0; x < projection.width(); ++x) out.at(x, y) = float(row[size_t(x)]);
  }
  return out;
}

}  // namespace

std::vector<double> angle_weights(const ScanGeometry& g) {
  const double period = g.beam == Beam::Cone ? 2 * std::numbers::pi : std::numbers::pi;
  const size_t n = g.angles.size();
  std::vector<size_t> order(n);
  std::iota(order.begin(), order.end(), size_t(0));
  std::vector<double> at(n);
  for (size_t i = 0; i < n; ++i) at[i] = g.angles[i] - period * std::floor(g.angles[i] / period);
  std::ranges::stable_sort(order, {}, [&](size_t i) { return at[i]; });
  std::vector<double> weights(n, period), gaps(n, period);
  for (size_t i = 0; i < n && n > 1; ++i)
    gaps[i] = i + 1 < n ? at[order[i + 1]] - at[order[i]] : at[order[0]] + period - at[order[i]];
  for (size_t i = 0; i < n && n > 1; ++i) weights[order[i]] = 0.5 * (gaps[i] + gaps[(i + n - 1) % n]);
  const double most = 2 * upper_median(weights);
  double sum = 0;
  for (double& w : weights) w = most > 0 ? std::min(w, most) : 1, sum += w;
  for (double& w : weights) w *= period / sum;
  return weights;
}

void filtered_backprojection(const ScanGeometry& g, std::span<const ImageF> projections, VoxelGrid<float>& grid) {
  const RampFilter filter(g.width, g.pixel_size / g.magnification());
  std::vector<ImageF> rows(projections.size());
  parallel_for(projections.size(), 1, [&](size_t i) { rows[i] = filtered(g, projections[i], filter); });
  std::vector<double> weights = angle_weights(g);
  if (g.beam == Beam::Cone)
    for (double& w : weights) w *= 0.5;
  grid.values.assign(grid.count(), 0.f);
  grid.each([&](int x, int y, int z) {
    const Vec3d point = grid.centre(x, y, z);
    double sum = 0;
    for (size_t i = 0; i < rows.size(); ++i) {
      const DetectorPoint d = detector_point(g, g.angles[i], point);
      if (d.depth > 0) sum += weights[i] / (d.depth * d.depth) * bilinear(rows[i], d.x, d.y);
    }
    grid.values[grid.index(x, y, z)] = float(sum);
  });
}

}  // namespace vitrine::test
