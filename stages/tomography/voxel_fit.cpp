#include "stages/tomography/voxel_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/quantile.h"
#include "stages/tomography/total_variation.h"

namespace vitrine {

namespace {

constexpr size_t kSteps = 38;          // of a round, at most: more projections are averaged
constexpr double kLastStep = 0.1;      // of the last round, as a share of the first
constexpr double kGoldenStep = 0.382;  // of the circle, between projections that follow each other
constexpr float kDenseShare = 0.99f;   // quantile of the densities that counts as dense
constexpr float kShortest = 1e-3f;     // cells of a ray in the grid: shorter ones count for nothing

struct RaySum {
  float integral = 0, length = 0;
};

// Trilinear samples a cell apart along the part of the ray near the grid; beyond the outer voxels' middles the density falls to
// 0.
RaySum along_ray(const VoxelGrid<float>& grid, const VolumeRay& ray) {
  const Vec3d origin = (ray.origin - grid.origin) / grid.cell - Vec3d{0.5, 0.5, 0.5}, d = ray.direction;
  double from = -1e30, to = 1e30;  // where all coordinates are in (-1, size)
  for (size_t k = 0; k < 3; ++k) {
    if (std::abs(d[k]) < 1e-12) {
      if (origin[k] <= -1 || origin[k] >= grid.size[k]) return {};
      continue;
    }
    const double a = (-1 - origin[k]) / d[k], b = (grid.size[k] - origin[k]) / d[k];
    from = std::max(from, std::min(a, b)), to = std::min(to, std::max(a, b));
  }
  RaySum out;
  const size_t next_y = size_t(grid.size[0]), next_z = next_y * size_t(grid.size[1]);
  for (double t = std::floor(from) + 0.5; t < to; ++t) {
    const Vec3f q = cast<float>(origin + t * d);
    const float fx = std::floor(q.x), fy = std::floor(q.y), fz = std::floor(q.z);
    const float tx = q.x - fx, ty = q.y - fy, tz = q.z - fz;
    const int x = int(fx), y = int(fy), z = int(fz);
    if (x >= 0 && y >= 0 && z >= 0 && x + 1 < grid.size[0] && y + 1 < grid.size[1] && z + 1 < grid.size[2]) {
      const float* v = &grid.values[grid.index(x, y, z)];
      const auto row = [&](const float* p) { return p[0] + tx * (p[1] - p[0]); };
      const float low = row(v) + ty * (row(v + next_y) - row(v)), v1 = row(v + next_z), v2 = row(v + next_z + next_y);
      out.integral += low + tz * (v1 + ty * (v2 - v1) - low);
      out.length += 1;
      continue;
    }
    for (int k = 0; k < 8; ++k) {
      const float w = (k % 2 ? tx : 1 - tx) * (k / 2 % 2 ? ty : 1 - ty) * (k / 4 ? tz : 1 - tz);
      if (!grid.has(x + k % 2, y + k / 2 % 2, z + k / 4)) continue;
      out.integral += w * grid.values[grid.index(x + k % 2, y + k / 2 % 2, z + k / 4)], out.length += w;
    }
  }
  return {out.integral * float(grid.cell), out.length * float(grid.cell)};
}

// Mean density that is missing along each ray; adds the squares of the differences of the line integrals.
ImageF missing_density(const ScanGeometry& g, double angle, const ImageF& projection, const VoxelGrid<float>& grid,
                       double& squares) {
  ImageF out(g.width, g.height, 1);
  const std::vector<VolumeRay> rays = scan_rays(g, angle);
  std::vector<double> rows(size_t(g.height), 0.);
  parallel_for(rows.size(), 1, [&](size_t y) {
    for (size_t i = y * size_t(g.width); i < (y + 1) * size_t(g.width); ++i) {
      const RaySum ray = along_ray(grid, rays[i]);
      const float left = projection.data()[i] - ray.integral;
      rows[y] += double(left) * double(left);
      out.data()[i] = ray.length > kShortest * float(grid.cell) ? left / ray.length : 0.f;
    }
  });
  squares += std::accumulate(rows.begin(), rows.end(), 0.);
  return out;
}

// Far from each other one after the other, each once.
std::vector<size_t> spread_order(size_t count) {
  size_t step = std::max<size_t>(1, size_t(kGoldenStep * double(count)));
  while (std::gcd(step, count) != 1) ++step;
  std::vector<size_t> order(count);
  for (size_t i = 0; i < count; ++i) order[i] = i * step % count;
  return order;
}

}  // namespace

void fit_voxels(const ScanGeometry& g, std::span<const ImageF> projections, VoxelGrid<float>& grid, const VoxelFitDesc& desc,
                const std::function<void(const FitRound&)>& progress) {
  grid.values.assign(grid.count(), 0.f);
  TotalVariation smoother(grid);
  const std::vector<size_t> order = spread_order(projections.size());
  const size_t each = (order.size() + kSteps - 1) / kSteps;
  for (int round = 0; round < desc.rounds; ++round) {
    const float step = float(std::pow(kLastStep, double(round) / desc.rounds));
    double squares = 0;
    for (size_t first = 0; first < order.size(); first += each) {
      throw_if_interrupted();
      const std::span<const size_t> views = std::span(order).subspan(first, std::min(each, order.size() - first));
      std::vector<ImageF> missing;
      for (const size_t v : views) missing.push_back(missing_density(g, g.angles[v], projections[v], grid, squares));
      const float share = step / float(views.size());
      grid.each([&](int x, int y, int z) {
        double sum = 0;
        for (size_t i = 0; i < views.size(); ++i) {
          const DetectorPoint d = detector_point(g, g.angles[views[i]], grid.centre(x, y, z));
          if (d.depth > 0) sum += bilinear(missing[i], d.x, d.y);
        }
        float& value = grid.values[grid.index(x, y, z)];
        value = std::max(0.f, value + share * float(sum));
      });
    }
    std::vector<float> values = grid.values;
    const float dense = quantile_of(values, kDenseShare);
    if (desc.tv > 0 && dense > 0) smoother.reduce(grid, float(desc.tv) * step * dense);
    if (progress) progress({round + 1, std::sqrt(squares / (double(projections.size()) * double(g.width) * double(g.height)))});
  }
}

std::vector<ImageF> projected(const ScanGeometry& g, const VoxelGrid<float>& grid) {
  std::vector<ImageF> out;
  for (const double angle : g.angles) {
    const std::vector<VolumeRay> rays = scan_rays(g, angle);
    ImageF& image = out.emplace_back(g.width, g.height, 1);
    parallel_for(size_t(g.height), 1, [&](size_t y) {
      for (size_t i = y * size_t(g.width); i < (y + 1) * size_t(g.width); ++i)
        image.data()[i] = along_ray(grid, rays[i]).integral;
    });
  }
  return out;
}

double bilinear(const ImageF& image, double px, double py) {
  const double fx = std::floor(px - 0.5), fy = std::floor(py - 0.5), tx = px - 0.5 - fx, ty = py - 0.5 - fy;
  if (!(fx >= -1 && fy >= -1 && fx < image.width() && fy < image.height())) return 0;
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    const int x = int(fx) + k % 2, y = int(fy) + k / 2;
    if (x >= 0 && y >= 0 && x < image.width() && y < image.height())
      sum += (k % 2 ? tx : 1 - tx) * (k / 2 ? ty : 1 - ty) * double(image.at(x, y));
  }
  return sum;
}

size_t voxel_fit_bytes(const VoxelGrid<float>& grid) {
  return grid.count() * sizeof(float) * (2 + TotalVariation::kFloatsPerVoxel);
}

}  // namespace vitrine
