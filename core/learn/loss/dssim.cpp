// D-SSIM:  L = sum_p m_p (1 - S_p) / sum_p m_p, averaged over the channels; S by ssim_kernel.h with zero padding.
// Structural similarity S of windowed moments (ssim_kernel.h), summed over an image with pixel weights m, and the gradient of
// that sum:
//   sum_p m_p S_p          d/dx = blur(m dS/dmu_x) + 2 x blur(m dS/dE[x^2]) + y blur(m dS/dE[xy]),   zero padding
// The blur is separable and self-adjoint: for each image row, first vertically (eight pixels per register), then horizontally
// in a padded buffer. No image of the moments is stored, only the three partial derivatives.
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include "core/learn/loss/loss.h"
#include "core/learn/loss/ssim_kernel.h"
#include "core/learn/loss/target_mask.h"

namespace vitrine {

namespace {

// Planes of two pictures [3,h,w] and the weight [h,w] or empty: 1.
struct PicturePair {
  int width, height;
  const float *x, *y;
  std::span<const float> weight;
  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
  double total_weight() const { return 3 * (weight.empty() ? static_cast<double>(pixels()) : sum_of(weight)); }
};

typedef float Lanes __attribute__((vector_size(32)));
constexpr int kLanes = 8, kTaps = 2 * kSsimRadius + 1;

template <class V>
V load(const float* p) {
  V v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
template <class V>
void store(float* p, const V& v) {
  std::memcpy(p, &v, sizeof v);
}

std::array<float, kTaps> window() {
  std::array<double, kTaps> k;
  double sum = 0;
  for (int t = 0; t < kTaps; ++t)
    sum += k[t] = std::exp(-0.5 * (t - kSsimRadius) * (t - kSsimRadius) / (kSsimSigma * kSsimSigma));
  std::array<float, kTaps> out;
  for (int t = 0; t < kTaps; ++t) out[t] = static_cast<float>(k[t] / sum);
  return out;
}
const std::array<float, kTaps> kWindow = window();

// Calls body(V{}, x) so that every x in [0, width) is covered: vectors, the last one shifted left to end at `width`.
// Bodies must be idempotent, because the shifted vector repeats some pixels.
template <class Body>
void for_lanes(int width, const Body& body) {
  if (width < kLanes) {
    for (int x = 0; x < width; ++x) body(float{}, x);
    return;
  }
  for (int x = 0; x + kLanes <= width; x += kLanes) body(Lanes{}, x);
  if (width % kLanes != 0) body(Lanes{}, width - kLanes);
}

// Rows of kSsimRadius zeros, `width` values, kSsimRadius zeros.
template <size_t N>
class PaddedRows {
 public:
  explicit PaddedRows(int width) : stride_(static_cast<size_t>(width + 2 * kSsimRadius)), data_(N * stride_, 0.f) {}
  float* row(size_t i) { return data_.data() + i * stride_ + kSsimRadius; }

 private:
  size_t stride_;
  std::vector<float> data_;
};

template <class V>
V blurred(const float* row, int x) {
  V sum = kWindow[kSsimRadius] * load<V>(row + x);
  for (int t = 1; t <= kSsimRadius; ++t) sum += kWindow[kSsimRadius + t] * (load<V>(row + x - t) + load<V>(row + x + t));
  return sum;
}

class WindowedSimilarity {
 public:
  // Sum of m (1 - S) over pixels and channels; keeps the partials for add_gradient.
  double dissimilarity(const PicturePair& image) {
    const size_t rows = 3 * static_cast<size_t>(image.height);
    for (auto& plane : partials_) plane.resize(3 * image.pixels());
    row_sums_.resize(rows);
    parallel_chunks(rows, kRowGrain, [&](size_t, size_t begin, size_t end) {
      PaddedRows<5> moments(image.width);
      std::vector<float> similarity(static_cast<size_t>(image.width));
      for (size_t row = begin; row < end; ++row) row_sums_[row] = similarity_row(image, row, moments, similarity);
    });
    double sum = 0;
    for (double s : row_sums_) sum += s;
    return sum;
  }

  // grad += step * d/dx of the sum of m S, for the image of the last call of dissimilarity().
  void add_gradient(const PicturePair& image, float step, float* grad) {
    parallel_chunks(3 * static_cast<size_t>(image.height), kRowGrain, [&](size_t, size_t begin, size_t end) {
      PaddedRows<3> blurs(image.width);
      std::vector<float> increment(static_cast<size_t>(image.width));
      for (size_t row = begin; row < end; ++row) gradient_row(image, row, step, blurs, increment, grad);
    });
  }

 private:
  struct Taps {
    int first, last;  // offsets of rows inside the image
  };
  static Taps taps_of(const PicturePair& image, size_t row) {
    const int y = static_cast<int>(row % static_cast<size_t>(image.height));
    return {std::max(-kSsimRadius, -y), std::min(kSsimRadius, image.height - 1 - y)};
  }

  // Moments of one row, then S, then the partials of sum_p m_p S_p. Returns sum over the row of m (1 - S).
  double similarity_row(const PicturePair& image, size_t row, PaddedRows<5>& moments, std::vector<float>& similarity) {
    const Taps taps = taps_of(image, row);
    const size_t begin = row * static_cast<size_t>(image.width);
    const float *x_row = image.x + begin, *y_row = image.y + begin;
    for_lanes(image.width, [&](auto lane, int x) {
      using V = decltype(lane);
      V mu_x{}, mu_y{}, xx{}, yy{}, xy{};
      for (int t = taps.first; t <= taps.last; ++t) {
        const float k = kWindow[t + kSsimRadius];
        const V a = load<V>(x_row + t * image.width + x), b = load<V>(y_row + t * image.width + x), ka = k * a, kb = k * b;
        mu_x += ka;
        mu_y += kb;
        xx += ka * a;
        yy += kb * b;
        xy += ka * b;
      }
      store(moments.row(0) + x, mu_x);
      store(moments.row(1) + x, mu_y);
      store(moments.row(2) + x, xx);
      store(moments.row(3) + x, yy);
      store(moments.row(4) + x, xy);
    });
    const float* weight = image.weight.empty() ? nullptr : image.weight.data() + begin % image.pixels();
    float *g_mu = partials_[0].data() + begin, *g_xx = partials_[1].data() + begin, *g_xy = partials_[2].data() + begin;
    for_lanes(image.width, [&](auto lane, int x) {
      using V = decltype(lane);
      const SsimPoint<V> p =
          ssim_point<V>({blurred<V>(moments.row(0), x), blurred<V>(moments.row(1), x), blurred<V>(moments.row(2), x),
                         blurred<V>(moments.row(3), x), blurred<V>(moments.row(4), x)});
      const V m = weight ? load<V>(weight + x) : V{} + 1.f;
      store(similarity.data() + x, V(m * (1.f - p.value)));
      store(g_mu + x, V(m * p.grad_mu_x));
      store(g_xx + x, V(m * p.grad_xx));
      store(g_xy + x, V(m * p.grad_xy));
    });
    return sum_of(similarity);
  }

  void gradient_row(const PicturePair& image, size_t row, float step, PaddedRows<3>& blurs, std::vector<float>& increment,
                    float* grad) {
    const Taps taps = taps_of(image, row);
    const size_t begin = row * static_cast<size_t>(image.width);
    const float *p0 = partials_[0].data() + begin, *p1 = partials_[1].data() + begin, *p2 = partials_[2].data() + begin;
    for_lanes(image.width, [&](auto lane, int x) {
      using V = decltype(lane);
      V a{}, b{}, c{};
      for (int t = taps.first; t <= taps.last; ++t) {
        const float k = kWindow[t + kSsimRadius];
        a += k * load<V>(p0 + t * image.width + x);
        b += k * load<V>(p1 + t * image.width + x);
        c += k * load<V>(p2 + t * image.width + x);
      }
      store(blurs.row(0) + x, a);
      store(blurs.row(1) + x, b);
      store(blurs.row(2) + x, c);
    });
    for_lanes(image.width, [&](auto lane, int x) {
      using V = decltype(lane);
      const V px = load<V>(image.x + begin + static_cast<size_t>(x)), py = load<V>(image.y + begin + static_cast<size_t>(x));
      const V g = blurred<V>(blurs.row(0), x) + (px + px) * blurred<V>(blurs.row(1), x) + py * blurred<V>(blurs.row(2), x);
      store(increment.data() + x, V(step * g));
    });
    for (size_t x = 0; x < increment.size(); ++x) grad[begin + x] += increment[x];
  }

  std::array<std::vector<float>, 3> partials_;
  std::vector<double> row_sums_;
};

class DssimLoss final : public Loss {
 public:
  std::string_view name() const override { return "dssim"; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const PicturePair pair{input.view->intrinsics.width, input.view->intrinsics.height, input.prediction_srgb.data(),
                           input.target_srgb.data(), input.weight};
    const double total = pair.total_weight();
    if (total <= 0) return 0;
    const double sum = similarity_.dissimilarity(pair);
    similarity_.add_gradient(pair, static_cast<float>(-scale / total), gradient.prediction_srgb.data());
    return sum / total;
  }

 private:
  WindowedSimilarity similarity_;
};

}  // namespace

std::unique_ptr<Loss> make_dssim_loss() { return std::make_unique<DssimLoss>(); }

}  // namespace vitrine
