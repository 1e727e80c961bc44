#include "stages/tomography/volume_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/quantile.h"
#include "core/render/volume/density_grid.h"
#include "core/render/volume/line_integrals.h"

namespace vitrine {

namespace {

constexpr size_t kValues = Gaussian3f::kValues;
constexpr double kTrainingCutoff = 3;               // standard deviations
constexpr double kOverlap = 0.65;                   // standard deviation of the start over the spacing: ripples below 2 %
constexpr double kLowestShare = 0.05;               // of the densest places, where Gaussians stand
constexpr int kBox = 32, kStepsPerBox = 2;          // cells along the side of a random box of the total variation
constexpr float kSmallest = 0.4f, kLargest = 16.f;  // standard deviations in cells: the grid shows nothing finer
// Step sizes at the start, by value: means and scales in cells; they fall to a tenth.
constexpr std::array<float, kValues> kRates{0.04f, 0.04f, 0.04f, 0.02f, 0.02f, 0.02f, 0.01f, 0.01f, 0.01f, 0.01f, 0.05f};

// Adam (Kingma and Ba 2015) on Gaussians with lengths in cells. Only Gaussians that the step reached move.
class GaussianAdam {
 public:
  explicit GaussianAdam(size_t count) : m_(count), v_(count), steps_(count, 0) {}

  void step(std::span<const Gaussian3Gradient> gradient, float rate, std::span<Gaussian3f> gaussians) {
    parallel_for(gaussians.size(), 256, [&](size_t i) {
      const Gaussian3Gradient& g = gradient[i];
      if (std::ranges::all_of(g, [](float x) { return x == 0; })) return;
      VITRINE_CHECK(std::ranges::all_of(g, [](float x) { return std::isfinite(x); }), "gradient of Gaussian {}", i);
      ++steps_[i];
      const float c1 = 1 - std::pow(kBeta1, float(steps_[i])), c2 = 1 - std::pow(kBeta2, float(steps_[i]));
      const float lowest = std::log(float(kSmallest)), highest = std::log(float(kLargest));
      auto x = values_of(gaussians[i]);
      for (size_t k = 0; k < kValues; ++k) {
        m_[i][k] += (1 - kBeta1) * (g[k] - m_[i][k]);
        v_[i][k] += (1 - kBeta2) * (g[k] * g[k] - v_[i][k]);
        x[k] -= rate * kRates[k] * (m_[i][k] / c1) / (std::sqrt(v_[i][k] / c2) + 1e-12f);
      }
      for (size_t k = 3; k < 6; ++k) x[k] = std::clamp(x[k], lowest, highest);
      gaussians[i] = gaussian3(x);
    });
  }

 private:
  static constexpr float kBeta1 = 0.9f, kBeta2 = 0.99f;
  std::vector<Gaussian3Gradient> m_, v_;
  std::vector<uint32_t> steps_;
};

// Lengths in cells from the middle of the scan, and back.
Gaussian3f scaled(Gaussian3f g, double factor) {
  const float shift = float(std::log(factor));
  g.mean = float(factor) * g.mean;
  g.log_scale += Vec3f{shift, shift, shift};
  g.log_density -= shift;
  return g;
}

// Total variation of the field in a box, smoothed near 0 over a hundredth of `typical`; adds its gradient times `weight`.
void add_total_variation(std::span<const Gaussian3f> gaussians, VoxelGrid<float> box, double typical, double weight,
                         std::span<Gaussian3Gradient> out) {
  sample_density(gaussians, box);
  VoxelGrid<float> gradient = box;
  gradient.values.assign(box.count(), 0.f);
  const float floor = float(0.01 * typical) * float(0.01 * typical), factor = float(weight / double(box.count()));
  box.each_in_order([&](int x, int y, int z) {
    if (x + 1 >= box.size[0] || y + 1 >= box.size[1] || z + 1 >= box.size[2]) return;
    const size_t i = box.index(x, y, z);
    const size_t next[3] = {box.index(x + 1, y, z), box.index(x, y + 1, z), box.index(x, y, z + 1)};
    float d[3], squared = floor;
    for (size_t k = 0; k < 3; ++k) d[k] = box.values[next[k]] - box.values[i], squared += d[k] * d[k];
    const float inverse = factor / std::sqrt(squared);
    for (size_t k = 0; k < 3; ++k) {
      gradient.values[next[k]] += inverse * d[k];
      gradient.values[i] -= inverse * d[k];
    }
  });
  sample_density_vjp(gaussians, gradient, out);
}

// A random box of the grid, which has cells of length 1 around the origin.
VoxelGrid<float> random_box(const std::array<int, 3>& size, Rng& rng) {
  VoxelGrid<float> box{.origin = {}, .cell = 1, .size = {}, .values = {}};
  for (size_t k = 0; k < 3; ++k) {
    box.size[k] = std::min(size[k], kBox);
    box.origin[k] = -0.5 * size[k] + double(rng.below(uint32_t(size[k] - box.size[k] + 1)));
  }
  return box;
}

// Each projection once per round, in a new order each time.
std::vector<uint32_t> shuffled(size_t count, uint64_t seed, uint64_t round) {
  std::vector<uint32_t> order(count);
  Rng rng(seed, round);
  for (uint32_t i = 0; i < count; ++i) {
    order[i] = i;
    std::swap(order[i], order[rng.below(i + 1)]);
  }
  return order;
}

double mean_square(std::span<const ImageF> projections) {
  double sum = 0, count = 0;
  for (const ImageF& p : projections) {
    for (const float v : p.data()) sum += double(v) * double(v);
    count += double(p.pixel_count());
  }
  return sum / count;
}

}  // namespace

std::vector<Gaussian3f> gaussians_of(const VoxelGrid<float>& volume, double spacing) {
  std::vector<float> values = volume.values;
  const float dense = quantile_of(values, 0.99), least = float(kLowestShare) * dense;
  const double step = spacing * volume.cell, sigma = kOverlap * step;
  const double share = std::pow(step / (sigma * std::sqrt(2 * std::numbers::pi)), 3);
  std::array<int, 3> count{};
  for (size_t k = 0; k < 3; ++k) count[k] = std::max(1, int(std::lround(volume.size[k] / spacing)));
  VoxelGrid<float> lattice{volume.origin, step, count,
                           std::vector<float>(size_t(count[0]) * size_t(count[1]) * size_t(count[2]))};
  std::vector<float> counted(lattice.count(), 0.f);
  volume.each_in_order([&](int x, int y, int z) {
    const auto [i, j, k] = lattice.cell_of(volume.centre(x, y, z));
    if (!lattice.has(i, j, k)) return;
    lattice.values[lattice.index(i, j, k)] += volume.at(x, y, z);
    counted[lattice.index(i, j, k)] += 1;
  });
  std::vector<Gaussian3f> out;
  lattice.each_in_order([&](int x, int y, int z) {
    const size_t i = lattice.index(x, y, z);
    const float mean = counted[i] > 0 ? lattice.values[i] / counted[i] : 0.f;
    if (!(mean > least && mean > 0)) return;
    const float scale = float(std::log(sigma));
    out.push_back({cast<float>(lattice.centre(x, y, z)), {scale, scale, scale}, {}, std::log(float(share) * mean)});
  });
  return out;
}

std::vector<Gaussian3f> fit_volume(const ScanGeometry& g, std::span<const ImageF> projections, const VoxelGrid<float>& grid,
                                   std::vector<Gaussian3f> gaussians, const VolumeFitDesc& desc,
                                   const std::function<void(const FitStep&)>& progress) {
  for (Gaussian3f& one : gaussians) one = scaled(one, 1 / grid.cell);
  std::vector<RayTiles> views;
  for (const double angle : g.angles) {
    std::vector<VolumeRay> rays = scan_rays(g, angle);
    for (VolumeRay& r : rays) r.origin = r.origin / grid.cell;
    views.emplace_back(rays, g.width, Vec3d{});
  }
  const double energy = std::max(mean_square(projections), 1e-30);
  const double typical = std::sqrt(energy) / std::max(1, grid.size[0]);  // density of a box as wide as the grid
  GaussianAdam adam(gaussians.size());
  std::vector<Gaussian3Gradient> gradient(gaussians.size());
  std::vector<uint32_t> order;
  for (int step = 0; step < desc.iterations; ++step) {
    throw_if_interrupted();
    const size_t at = size_t(step) % views.size();
    if (at == 0) order = shuffled(views.size(), desc.seed, uint64_t(step));
    const ImageF& wanted = projections[order[at]];
    gradient.assign(gaussians.size(), {});
    const LineIntegrals integrals(views[order[at]], gaussians, kTrainingCutoff);
    std::vector<float> error(wanted.pixel_count());
    integrals.forward(error);
    double sum = 0;
    const double factor = 2 / (energy * double(error.size()));
    for (size_t i = 0; i < error.size(); ++i) {
      const double difference = double(error[i]) - double(wanted.data()[i]);
      sum += difference * difference;
      error[i] = float(factor * difference);
    }
    integrals.backward(error, gradient);
    if (desc.tv > 0 && step % kStepsPerBox == 0) {
      Rng rng(mix64(desc.seed, 0x7476), uint64_t(step));
      add_total_variation(gaussians, random_box(grid.size, rng), typical, kStepsPerBox * desc.tv / typical / 100, gradient);
    }
    adam.step(gradient, float(std::pow(0.1, double(step) / desc.iterations)), gaussians);
    if (progress) progress({step + 1, std::sqrt(sum / double(error.size()))});
  }
  for (Gaussian3f& one : gaussians) one = scaled(one, grid.cell);
  return gaussians;
}

std::vector<ImageF> projected(const ScanGeometry& g, std::span<const Gaussian3f> gaussians) {
  std::vector<ImageF> out;
  for (const double angle : g.angles) {
    const RayTiles tiles(scan_rays(g, angle), g.width, {});
    LineIntegrals(tiles, gaussians).forward(out.emplace_back(g.width, g.height, 1).data());
  }
  return out;
}

}  // namespace vitrine
