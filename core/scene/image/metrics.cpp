#include "core/scene/image/metrics.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr double kEqualImagesDb = 99.0;
constexpr int kWindowRadius = 5;
constexpr int kCorrelationWindow = 7;
constexpr double kPlain = 1e-6;                         // minimum window variance: a quarter of an 8-bit step, squared
constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;  // for values in [0, 1]

void check_sizes(const ImageF& a, const ImageF& b, const ImageF* mask) {
  VITRINE_CHECK(a.width() == b.width() && a.height() == b.height() && a.channels() == b.channels(), "images of {}x{} and {}x{}",
                a.width(), a.height(), b.width(), b.height());
  VITRINE_CHECK(!mask || (mask->width() == a.width() && mask->height() == a.height() && mask->channels() == 1),
                "mask size differs");
}

using Plane = std::vector<double>;

// Gaussian blur with zero padding, as in the reference implementations.
Plane blurred(const Plane& in, int width, int height, const std::array<double, 2 * kWindowRadius + 1>& kernel) {
  Plane rows(in.size()), out(in.size());
  parallel_for(size_t(height), 16, [&](size_t y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int k = -kWindowRadius; k <= kWindowRadius; ++k)
        if (x + k >= 0 && x + k < width) sum += kernel[size_t(k + kWindowRadius)] * in[y * size_t(width) + size_t(x + k)];
      rows[y * size_t(width) + size_t(x)] = sum;
    }
  });
  parallel_for(size_t(height), 16, [&](size_t row) {
    const int y = int(row);
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int k = -kWindowRadius; k <= kWindowRadius; ++k)
        if (y + k >= 0 && y + k < height)
          sum += kernel[size_t(k + kWindowRadius)] * rows[size_t(y + k) * size_t(width) + size_t(x)];
      out[row * size_t(width) + size_t(x)] = sum;
    }
  });
  return out;
}

}  // namespace

SquaredError& SquaredError::operator+=(const SquaredError& other) {
  sum += other.sum, weight += other.weight;
  return *this;
}

double SquaredError::psnr() const {
  if (weight <= 0) return std::numeric_limits<double>::quiet_NaN();
  return sum == 0 ? kEqualImagesDb : std::min(kEqualImagesDb, -10.0 * std::log10(sum / weight));
}

SquaredError squared_error(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask) {
  check_sizes(srgb, reference_srgb, mask);
  SquaredError out;
  for (int y = 0; y < srgb.height(); ++y)
    for (int x = 0; x < srgb.width(); ++x) {
      const double w = mask ? mask->at(x, y) : 1.0;
      out.weight += w * srgb.channels();
      for (int c = 0; c < srgb.channels(); ++c) {
        const double d = double(srgb.at(x, y, c)) - reference_srgb.at(x, y, c);
        out.sum += w * d * d;
      }
    }
  return out;
}

double psnr(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask) {
  return squared_error(srgb, reference_srgb, mask).psnr();
}

LocalCorrelation& LocalCorrelation::operator+=(const LocalCorrelation& other) {
  covariance += other.covariance, variance += other.variance, reference_variance += other.reference_variance;
  return *this;
}

std::optional<double> LocalCorrelation::value() const {
  const double scale = std::sqrt(variance * reference_variance);
  return scale > 0 ? std::optional(covariance / scale) : std::nullopt;
}

LocalCorrelation local_correlation(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask) {
  check_sizes(srgb, reference_srgb, mask);
  const auto grey = [](const ImageF& image, int x, int y) {
    double sum = 0;
    for (int c = 0; c < image.channels(); ++c) sum += image.at(x, y, c);
    return sum / image.channels();
  };
  // Summed-area table: sums over all pixels above and left; first row and column are zero.
  struct Sums {
    double inside = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    Sums& add(const Sums& o, double sign) {
      inside += sign * o.inside, a += sign * o.a, b += sign * o.b, aa += sign * o.aa, bb += sign * o.bb, ab += sign * o.ab;
      return *this;
    }
  };
  const int width = srgb.width(), height = srgb.height();
  std::vector<Sums> table(size_t(width + 1) * size_t(height + 1));
  const auto at = [&](int x, int y) -> Sums& { return table[size_t(y) * size_t(width + 1) + size_t(x)]; };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double a = grey(srgb, x, y), b = grey(reference_srgb, x, y);
      Sums sums{mask == nullptr || mask->at(x, y) == 1.f ? 1.0 : 0.0, a, b, a * a, b * b, a * b};
      at(x + 1, y + 1) = sums.add(at(x, y + 1), 1).add(at(x + 1, y), 1).add(at(x, y), -1);
    }
  constexpr double kCount = kCorrelationWindow * kCorrelationWindow;
  LocalCorrelation out;
  for (int y = kCorrelationWindow; y <= height; ++y)
    for (int x = kCorrelationWindow; x <= width; ++x) {
      Sums sums = at(x, y);
      sums.add(at(x - kCorrelationWindow, y), -1).add(at(x, y - kCorrelationWindow), -1);
      sums.add(at(x - kCorrelationWindow, y - kCorrelationWindow), 1);
      if (sums.inside < kCount) continue;
      const double variance = sums.aa / kCount - sums.a / kCount * (sums.a / kCount),
                   of_reference = sums.bb / kCount - sums.b / kCount * (sums.b / kCount);
      if (std::max(variance, of_reference) < kPlain) continue;
      out.covariance += sums.ab / kCount - sums.a / kCount * (sums.b / kCount);
      out.variance += std::max(0.0, variance), out.reference_variance += std::max(0.0, of_reference);
    }
  return out;
}

double ssim(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask) {
  check_sizes(srgb, reference_srgb, mask);
  std::array<double, 2 * kWindowRadius + 1> kernel{};
  double sum = 0;
  for (int k = -kWindowRadius; k <= kWindowRadius; ++k)
    sum += kernel[size_t(k + kWindowRadius)] = std::exp(-k * k / (2 * 1.5 * 1.5));
  for (double& k : kernel) k /= sum;

  const int width = srgb.width(), height = srgb.height();
  const size_t n = srgb.pixel_count();
  double total = 0, weight = 0;
  for (int c = 0; c < srgb.channels(); ++c) {
    Plane a(n), b(n), aa(n), bb(n), ab(n);
    for (size_t i = 0; i < n; ++i) {
      a[i] = srgb.data()[i * size_t(srgb.channels()) + size_t(c)];
      b[i] = reference_srgb.data()[i * size_t(srgb.channels()) + size_t(c)];
      aa[i] = a[i] * a[i];
      bb[i] = b[i] * b[i];
      ab[i] = a[i] * b[i];
    }
    const Plane ma = blurred(a, width, height, kernel), mb = blurred(b, width, height, kernel);
    const Plane maa = blurred(aa, width, height, kernel), mbb = blurred(bb, width, height, kernel),
                mab = blurred(ab, width, height, kernel);
    for (size_t i = 0; i < n; ++i) {
      const double va = maa[i] - ma[i] * ma[i], vb = mbb[i] - mb[i] * mb[i], cov = mab[i] - ma[i] * mb[i];
      const double s = ((2 * ma[i] * mb[i] + kC1) * (2 * cov + kC2)) / ((ma[i] * ma[i] + mb[i] * mb[i] + kC1) * (va + vb + kC2));
      const double w = mask ? mask->data()[i] : 1.0;
      total += w * s;
      weight += w;
    }
  }
  return weight > 0 ? total / weight : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace vitrine
