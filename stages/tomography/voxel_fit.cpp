#include "stages/tomography/voxel_fit.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/foundation/base/checkpoint.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
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

// The place that a fit has reached.
struct FitPlace {
  int32_t round = 0;
  uint64_t first = 0;  // in the order of projections, the next one
  double squares = 0;  // of this round's differences
};

// Place, densities and the memory of the smoother as bytes.
template <class Move>
void move_state(FitPlace& place, VoxelGrid<float>& grid, TotalVariation& smoother, Move&& move) {
  move(&place.round, sizeof place.round), move(&place.first, sizeof place.first), move(&place.squares, sizeof place.squares);
  move(grid.values.data(), grid.values.size() * sizeof(float));
  for (std::vector<float>& d : smoother.dual()) move(d.data(), d.size() * sizeof(float));
}
void save(const fs::path& file, FitPlace place, VoxelGrid<float>& grid, TotalVariation& smoother) {
  std::string state;
  move_state(place, grid, smoother, [&](void* data, size_t size) { state.append(static_cast<const char*>(data), size); });
  write_checkpoint(file, state);
}
// The beginning without a file. A damaged one is logged and not used.
FitPlace restored(const fs::path& file, VoxelGrid<float>& grid, TotalVariation& smoother) {
  FitPlace place;
  try {
    const std::optional<std::string> state = read_checkpoint(file);
    if (!state) return place;
    size_t at = 0;
    move_state(place, grid, smoother, [&](void*, size_t size) { at += size; });
    if (at != state->size()) return place;  // of another grid: the key of the artifact excludes it
    at = 0;
    move_state(place, grid, smoother, [&](void* data, size_t size) { std::memcpy(data, &(*state)[at], size), at += size; });
    log_info("the fit goes on in round {}", place.round + 1);
  } catch (const Error& error) {
    log_info("{}", error.what());
  }
  return place;
}

// Adds what the rays of `views` lack; returns the sum of the squares of their differences before.
double fit_step(const ScanGeometry& g, std::span<const ImageF> projections, std::span<const size_t> views, float step,
                VoxelGrid<float>& grid) {
  double squares = 0;
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
  return squares;
}

}  // namespace

void fit_voxels(const ScanGeometry& g, std::span<const ImageF> projections, VoxelGrid<float>& grid, const VoxelFitDesc& desc,
                const std::function<void(const FitRound&)>& progress) {
  grid.values.assign(grid.count(), 0.f);
  TotalVariation smoother(grid);
  FitPlace place;
  if (!desc.checkpoint.empty()) place = restored(desc.checkpoint, grid, smoother);
  const std::vector<size_t> order = spread_order(projections.size());
  const size_t each = (order.size() + kSteps - 1) / kSteps;
  while (place.round < desc.rounds) {
    const float step = float(std::pow(kLastStep, double(place.round) / desc.rounds));
    while (place.first < order.size()) {
      if (interrupt_signal() != 0 && !desc.checkpoint.empty()) save(desc.checkpoint, place, grid, smoother);
      throw_if_interrupted();
      const size_t count = std::min(each, order.size() - place.first);
      place.squares += fit_step(g, projections, std::span(order).subspan(place.first, count), step, grid);
      place.first += count;
      const double pixels = double(place.first) * double(g.width) * double(g.height);
      if (progress) progress({place.round + 1, double(place.first) / double(order.size()), std::sqrt(place.squares / pixels)});
    }
    std::vector<float> values = grid.values;
    const float dense = quantile_of(values, kDenseShare);
    if (desc.tv > 0 && dense > 0) smoother.reduce(grid, float(desc.tv) * step * dense);
    place = {.round = place.round + 1};
    if (!desc.checkpoint.empty() && place.round < desc.rounds) save(desc.checkpoint, place, grid, smoother);
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
  constexpr size_t kOfCheckpoint = 2 * 4;  // densities and dual variables, in its state and in the file's bytes
  return grid.count() * sizeof(float) * (2 + TotalVariation::kFloatsPerVoxel + kOfCheckpoint);
}

}  // namespace vitrine
