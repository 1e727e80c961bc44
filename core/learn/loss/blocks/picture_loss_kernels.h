// The losses of the picture, L1 and D-SSIM (l1.cpp, dssim.cpp), as kernels for a GPU (core/render/raster/blocks/block_kernel.h).
// A thread of a pixel adds up its own window; sums over the picture are trees (tree_sum.h).
#pragma once

#include "core/learn/loss/ssim_kernel.h"
#include "core/render/raster/blocks/tree_sum.h"

namespace vitrine::blocks {

// Planes are [3,h,w]; the weight [h,w], or null: 1.
struct PicturePair {
  const float *prediction, *target, *weight;
  uint32_t width, height;
  VITRINE_HD uint32_t pixels() const { return width * height; }
  VITRINE_HD F32 weight_at(size_t pixel) const { return weight == nullptr ? 1.f : weight[pixel]; }
};

// Factors of the gradients. The weights of all pixels are added up on the device; null: `pixels` of weight one.
struct PictureLossScale {
  float l1, dssim;
  const float* weight_sum;
  // scale / (3 sum of the weights); 0 if there is none.
  VITRINE_HD F32 of(F32 scale, uint32_t pixels) const {
    const F32 total = F32(3.f) * (weight_sum == nullptr ? F32(static_cast<float>(pixels)) : F32(*weight_sum));
    return total > F32(0.f) ? scale / total : F32(0.f);
  }
};

// A thread for each pixel: m |C - C_photo|, a sum over the channels, its gradient, m times the mean over the channels, and the
// mean without m.
struct L1Kernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  PicturePair pair;
  PictureLossScale scale;
  float *gradient, *value, *error, *plain;  // [3,h,w], [h,w], [h,w], [h,w]

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t pixel = at.block * kThreads + at.thread, pixels = pair.pixels();
    if (pixel >= pixels) return;
    const F32 m = pair.weight_at(pixel), step = m * scale.of(scale.l1, pixels);
    F32 sum = 0.f;
    for (uint32_t c = 0; c < 3; ++c) {
      const size_t i = size_t{c} * pixels + pixel;
      const F32 difference = F32(pair.prediction[i]) - F32(pair.target[i]);
      sum += absolute(difference);
      gradient[i] = difference == F32(0.f) ? 0.f : difference > F32(0.f) ? step.v : -step.v;
    }
    value[pixel] = (m * sum).v;
    error[pixel] = (m * sum / F32(3.f)).v;
    plain[pixel] = (sum / F32(3.f)).v;
  }
};

// Windows of 11 x 11 pixels, by rows and then by columns; weights of a Gaussian of deviation 1.5, rounded to float.
VITRINE_HD inline F32 ssim_window(int offset) {
  constexpr float kWeights[kSsimRadius + 1] = {0.266011725f,  0.213005538f,   0.10936069f,
                                               0.0360007721f, 0.00759875814f, 0.00102838008f};
  return kWeights[offset < 0 ? -offset : offset];
}

// A tile of 16 x 16 pixels of one channel with the border of its windows.
struct WindowTile {
  static constexpr uint32_t kSide = 16, kThreads = kSide * kSide, kEdge = kSide + 2 * kSsimRadius;
  uint32_t across, down;
  VITRINE_HD WindowTile(uint32_t width, uint32_t height)
      : across((width + kSide - 1) / kSide), down((height + kSide - 1) / kSide) {}
  VITRINE_HD uint32_t blocks() const { return 3 * across * down; }
  VITRINE_HD uint32_t channel(uint32_t block) const { return block / (across * down); }
  // Of the corner of the tile.
  VITRINE_HD uint32_t x(uint32_t block) const { return block % across * kSide; }
  VITRINE_HD uint32_t y(uint32_t block) const { return block / across % down * kSide; }

  // put(row, column, index into the plane) for the pixels of the tile and its border that lie in the picture, blank(row, column)
  // for the others; of each pixel by one thread.
  template <class Put, class Blank>
  VITRINE_HD void load(Place at, uint32_t width, uint32_t height, const Put& put, const Blank& blank) const {
    for (uint32_t k = at.thread; k < kEdge * kEdge; k += kThreads) {
      const uint32_t row = k / kEdge, column = k % kEdge;
      const uint32_t px = x(at.block) + column - kSsimRadius, py = y(at.block) + row - kSsimRadius;  // wraps below zero
      if (px < width && py < height)
        put(row, column, (size_t{channel(at.block)} * height + py) * width + px);
      else
        blank(row, column);
    }
  }
  // blurred(row, column) for the pixels of the tile in all rows.
  template <class Blur>
  VITRINE_HD static void rows(Place at, const Blur& blurred) {
    for (uint32_t k = at.thread; k < kEdge * kSide; k += kThreads) blurred(k / kSide, k % kSide);
  }
};

// Partial derivatives of the sum of m S (dssim.cpp), planes [3,h,w].
struct SsimPartials {
  float *mu_x, *xx, *xy;
};

struct SsimKernel {
  static constexpr uint32_t kThreads = WindowTile::kThreads;
  struct Shared {
    float x[WindowTile::kEdge][WindowTile::kEdge], y[WindowTile::kEdge][WindowTile::kEdge];
    float rows[5][WindowTile::kEdge][WindowTile::kSide];
  };
  using Thread = NoThread;
  PicturePair pair;
  SsimPartials out;
  float* value;  // [3,h,w]: m (1 - S)

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 3; }
  VITRINE_HD void run(uint32_t phase, Place at, Thread&, Shared& s) const {
    const WindowTile tile(pair.width, pair.height);
    if (phase == 0) {
      tile.load(
          at, pair.width, pair.height,
          [&](uint32_t row, uint32_t column, size_t i) {
            s.x[row][column] = pair.prediction[i];
            s.y[row][column] = pair.target[i];
          },
          [&](uint32_t row, uint32_t column) { s.x[row][column] = s.y[row][column] = 0.f; });
    } else if (phase == 1) {
      WindowTile::rows(at, [&](uint32_t row, uint32_t column) {
        F32 sums[5] = {0.f, 0.f, 0.f, 0.f, 0.f};
        for (int t = -kSsimRadius; t <= kSsimRadius; ++t) {
          const uint32_t from = column + static_cast<uint32_t>(t + kSsimRadius);
          const F32 x = s.x[row][from], y = s.y[row][from], kx = ssim_window(t) * x, ky = ssim_window(t) * y;
          sums[0] += kx;
          sums[1] += ky;
          sums[2] += kx * x;
          sums[3] += ky * y;
          sums[4] += kx * y;
        }
        for (uint32_t k = 0; k < 5; ++k) s.rows[k][row][column] = sums[k].v;
      });
    } else {
      finish(tile, at, s);
    }
  }
  VITRINE_HD void finish(const WindowTile& tile, Place at, const Shared& s) const {
    const uint32_t column = at.thread % WindowTile::kSide, row = at.thread / WindowTile::kSide;
    const uint32_t px = tile.x(at.block) + column, py = tile.y(at.block) + row;
    if (px >= pair.width || py >= pair.height) return;
    F32 sums[5] = {0.f, 0.f, 0.f, 0.f, 0.f};
    for (int t = -kSsimRadius; t <= kSsimRadius; ++t)
      for (uint32_t k = 0; k < 5; ++k)
        sums[k] += ssim_window(t) * F32(s.rows[k][row + static_cast<uint32_t>(t + kSsimRadius)][column]);
    const SsimPoint<F32> p = ssim_point<F32>({sums[0], sums[1], sums[2], sums[3], sums[4]});
    const size_t pixel = size_t{py} * pair.width + px, i = size_t{tile.channel(at.block)} * pair.pixels() + pixel;
    const F32 m = pair.weight_at(pixel);
    value[i] = (m * (F32(1.f) - p.value)).v;
    out.mu_x[i] = (m * p.grad_mu_x).v;
    out.xx[i] = (m * p.grad_xx).v;
    out.xy[i] = (m * p.grad_xy).v;
  }
};

// Adds the gradient of D-SSIM.
struct SsimGradientKernel {
  static constexpr uint32_t kThreads = WindowTile::kThreads;
  struct Shared {
    float partials[3][WindowTile::kEdge][WindowTile::kEdge];
    float rows[3][WindowTile::kEdge][WindowTile::kSide];
  };
  using Thread = NoThread;
  PicturePair pair;
  PictureLossScale scale;
  SsimPartials in;
  float* gradient;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 3; }
  VITRINE_HD void run(uint32_t phase, Place at, Thread&, Shared& s) const {
    const WindowTile tile(pair.width, pair.height);
    if (phase == 0) {
      tile.load(
          at, pair.width, pair.height,
          [&](uint32_t row, uint32_t column, size_t i) {
            s.partials[0][row][column] = in.mu_x[i];
            s.partials[1][row][column] = in.xx[i];
            s.partials[2][row][column] = in.xy[i];
          },
          [&](uint32_t row, uint32_t column) {
            for (uint32_t k = 0; k < 3; ++k) s.partials[k][row][column] = 0.f;
          });
    } else if (phase == 1) {
      WindowTile::rows(at, [&](uint32_t row, uint32_t column) {
        for (uint32_t k = 0; k < 3; ++k) {
          F32 sum = 0.f;
          for (int t = -kSsimRadius; t <= kSsimRadius; ++t)
            sum += ssim_window(t) * F32(s.partials[k][row][column + static_cast<uint32_t>(t + kSsimRadius)]);
          s.rows[k][row][column] = sum.v;
        }
      });
    } else {
      finish(tile, at, s);
    }
  }
  VITRINE_HD void finish(const WindowTile& tile, Place at, const Shared& s) const {
    const uint32_t column = at.thread % WindowTile::kSide, row = at.thread / WindowTile::kSide;
    const uint32_t px = tile.x(at.block) + column, py = tile.y(at.block) + row;
    if (px >= pair.width || py >= pair.height) return;
    F32 sums[3] = {0.f, 0.f, 0.f};
    for (int t = -kSsimRadius; t <= kSsimRadius; ++t)
      for (uint32_t k = 0; k < 3; ++k)
        sums[k] += ssim_window(t) * F32(s.rows[k][row + static_cast<uint32_t>(t + kSsimRadius)][column]);
    const size_t i = size_t{tile.channel(at.block)} * pair.pixels() + size_t{py} * pair.width + px;
    const F32 x(pair.prediction[i]), y(pair.target[i]);
    const F32 slope = sums[0] + (x + x) * sums[1] + y * sums[2];
    gradient[i] = (F32(gradient[i]) - scale.of(scale.dssim, pair.pixels()) * slope).v;
  }
};

// Weights of the losses in the gradient; 0: it is left out.
struct PictureLossWeights {
  float l1 = 0, dssim = 0;
};

template <class Executor>
class PictureLossBlocks {
 public:
  // Writes the gradient [3,h,w] of the weighted sum, and the error image [h,w] of Training::write_error_image. All pointers are
  // of the executor's memory.
  void evaluate(Executor& executor, const PicturePair& pair, const PictureLossWeights& weights, float* gradient, float* error) {
    const uint32_t pixels = pair.pixels();
    l1_.resize(pixels);
    plain_.resize(pixels);
    PictureLossScale scale{weights.l1, weights.dssim, nullptr};
    if (pair.weight != nullptr) scale.weight_sum = tree_sum(executor, weight_sum_, pair.weight, pixels);
    executor.launch(L1Kernel{pair, scale, gradient, l1_.data(), error, plain_.data()}, blocks_for(pixels, L1Kernel::kThreads));
    dssim_.resize(size_t{3} * pixels);
    for (auto& p : partials_) p.resize(size_t{3} * pixels);
    const SsimPartials partials{partials_[0].data(), partials_[1].data(), partials_[2].data()};
    const uint32_t blocks = WindowTile(pair.width, pair.height).blocks();
    executor.launch(SsimKernel{pair, partials, dssim_.data()}, blocks);
    if (weights.dssim != 0.f) executor.launch(SsimGradientKernel{pair, scale, partials, gradient}, blocks);
    pixels_ = pixels;
    total_ = scale.weight_sum;
  }

  // Of the last evaluate(), in the executor's memory: sums over the picture of m |C - C_photo| and of m (1 - S), each over the
  // channels, too; of the mean of |C - C_photo| over the channels; of m, null: one of each pixel.
  struct Sums {
    const float *l1, *dssim, *plain, *weight;
  };
  Sums sums(Executor& executor) {
    return {tree_sum(executor, l1_sum_, l1_.data(), pixels_), tree_sum(executor, dssim_sum_, dssim_.data(), 3 * pixels_),
            tree_sum(executor, plain_sum_, plain_.data(), pixels_), total_};
  }

  // Of the last evaluate(): the losses themselves. Waits for the device.
  struct Values {
    double l1, dssim;
  };
  Values values(Executor& executor) {
    const Sums sums = this->sums(executor);
    const auto value = [&](const float* sum) { return static_cast<double>(executor.read(sum)); };
    const double total = 3.0 * (sums.weight == nullptr ? static_cast<double>(pixels_) : value(sums.weight));
    if (total <= 0) return {0, 0};
    return {value(sums.l1) / total, value(sums.dssim) / total};
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;
  TreeSumMemory<Executor> weight_sum_, l1_sum_, dssim_sum_, plain_sum_;
  Array<float> l1_, plain_, dssim_, partials_[3];
  const float* total_ = nullptr;
  uint32_t pixels_ = 0;
};

}  // namespace vitrine::blocks
