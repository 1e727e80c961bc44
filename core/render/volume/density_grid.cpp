#include "core/render/volume/density_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/render/volume/kernels/density.h"
#include "core/render/volume/kernels/exponential.h"
#include "core/render/volume/line_integrals.h"

namespace vitrine {

namespace {

constexpr size_t kGridTask = 64;

struct Footprint {
  Whitened<double> white;
  Vec3d mean;
  std::array<int, 3> low, high;  // cells [low, high) whose centres may be within the cutoff
};

// Half extent along an axis: cutoff times the square root of that element of the covariance.
Footprint footprint(const Gaussian3f& gaussian, const VoxelGrid<float>& grid) {
  const Gaussian3d g = cast<double>(gaussian);
  Footprint out{whitened(g), g.mean, {}, {}};
  const Mat3d r = rotation_matrix(normalized(g.rotation));
  for (size_t j = 0; j < 3; ++j) {
    double variance = 0;
    for (size_t k = 0; k < 3; ++k) variance += std::pow(r(j, k) * std::exp(g.log_scale[k]), 2);
    const double half = kVolumeCutoff * std::sqrt(variance), cells = double(grid.size[j]);
    const double from = (g.mean[j] - half - grid.origin[j]) / grid.cell - 0.5, to = from + 2 * half / grid.cell;
    out.low[j] = int(std::ceil(std::clamp(from, 0., cells)));
    out.high[j] = int(std::floor(std::clamp(to, -1., cells - 1))) + 1;
  }
  return out;
}

// Cells of a row within the cutoff: at cell x the whitened offset is start + x step.
struct Row {
  int begin = 0, end = 0;
  Vec3d start{}, step{};
};

Row row_of(const Footprint& f, const VoxelGrid<float>& grid, int y, int z) {
  Row row;
  row.start = f.white.matrix * (grid.centre(0, y, z) - f.mean), row.step = grid.cell * f.white.matrix.c0;
  const double squared = squared_length(row.step), middle = -dot(row.start, row.step) / squared;
  const double rest = kVolumeCutoff * kVolumeCutoff - squared_length(row.start + middle * row.step);
  if (rest < 0) return row;
  const double half = std::sqrt(rest / squared);
  row.begin = std::max(f.low[0], int(std::ceil(std::clamp(middle - half, 0., double(f.high[0])))));
  row.end = std::min(f.high[0], int(std::floor(std::clamp(middle + half, -1., double(f.high[0])))) + 1);
  return row;
}

// Density at the cells begin + i, i < end - begin.
void row_values(const Row& row, double density, float* values) {
  const Vec3f at = cast<float>(row.start + double(row.begin) * row.step), step = cast<float>(row.step);
  const int count = row.end - row.begin;
  const float peak = float(density);
  for (int i = 0; i < count; ++i) {
    const float x = at.x + float(i) * step.x, y = at.y + float(i) * step.y, z = at.z + float(i) * step.z;
    values[i] = peak * exponential(-0.5f * (x * x + y * y + z * z));
  }
}

}  // namespace

void sample_density(std::span<const Gaussian3f> gaussians, VoxelGrid<float>& grid) {
  grid.values.assign(grid.count(), 0.f);
  std::vector<Footprint> footprints(gaussians.size());
  parallel_for(gaussians.size(), kGridTask, [&](size_t i) { footprints[i] = footprint(gaussians[i], grid); });
  parallel_for(size_t(grid.size[2]), 1, [&](size_t layer) {
    const int z = int(layer);
    std::vector<float> values(static_cast<size_t>(grid.size[0]));
    for (const Footprint& f : footprints) {
      if (z < f.low[2] || z >= f.high[2]) continue;
      for (int y = f.low[1]; y < f.high[1]; ++y) {
        const Row row = row_of(f, grid, y, z);
        if (row.begin >= row.end) continue;
        row_values(row, f.white.density, values.data());
        float* out = &grid.values[grid.index(row.begin, y, z)];
        for (int i = 0; i < row.end - row.begin; ++i) out[i] += values[size_t(i)];
      }
    }
  });
}

// In a row, q = q0 + i s and r = r0 + i e: three moments of the weights -g f over i give all sums.
void sample_density_vjp(std::span<const Gaussian3f> gaussians, const VoxelGrid<float>& gradient,
                        std::span<Gaussian3Gradient> out) {
  VITRINE_CHECK(gradient.values.size() == gradient.count() && out.size() == gaussians.size(), "gradients of another grid");
  parallel_chunks(gaussians.size(), kGridTask, [&](size_t, size_t first, size_t last) {
    std::vector<float> values(static_cast<size_t>(gradient.size[0]));
    for (size_t n = first; n < last; ++n) {
      const Footprint f = footprint(gaussians[n], gradient);
      WhitenedGradient<double> sums;
      for (int z = f.low[2]; z < f.high[2]; ++z)
        for (int y = f.low[1]; y < f.high[1]; ++y) {
          const Row row = row_of(f, gradient, y, z);
          if (row.begin >= row.end) continue;
          row_values(row, f.white.density, values.data());
          const float* g = &gradient.values[gradient.index(row.begin, y, z)];
          double s0 = 0, s1 = 0, s2 = 0;
          for (int i = 0; i < row.end - row.begin; ++i) {
            const double weight = -double(values[size_t(i)]) * double(g[i]);
            s0 += weight, s1 += weight * i, s2 += weight * i * i;
          }
          const Vec3d q = row.start + double(row.begin) * row.step, r = gradient.centre(row.begin, y, z) - f.mean;
          const Vec3d zeroth = s0 * q + s1 * row.step, along = gradient.cell * (s1 * q + s2 * row.step);
          sums.offset += zeroth;
          for (size_t j = 0; j < 3; ++j) sums.matrix.column(j) += r[j] * zeroth;
          sums.matrix.c0 += along;
          sums.log_density -= s0;
        }
      const auto added = values_of(cast<float>(whitened_vjp(cast<double>(gaussians[n]), f.white, sums)));
      for (size_t v = 0; v < added.size(); ++v) out[n][v] += added[v];
    }
  });
}

}  // namespace vitrine
