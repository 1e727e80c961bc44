#include "core/observe/stereo/visual_hull.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"

namespace vitrine {

namespace {

constexpr int kCoarse = 48;            // resolution of the coarse pass over the whole cube
constexpr int kPadding = 4;            // voxels around the result, so that the blurred surface is closed
constexpr int kBlurPasses = 3;         // of a 3-voxel box filter: approximates a Gaussian of sqrt(2/3 passes) voxels
constexpr float kSurfaceLevel = 0.5f;  // occupancy at the surface

VoxelGrid<uint8_t> grid_over(const Bounds3& bounds, int resolution, int padding) {
  const Vec3d extent = bounds.high - bounds.low;
  const double voxel = std::max({extent.x, extent.y, extent.z}) / resolution;
  VoxelGrid<uint8_t> grid{bounds.low - (padding * voxel) * Vec3d{1, 1, 1}, voxel, {}, {}};
  for (size_t i = 0; i < 3; ++i) grid.size[i] = int(std::ceil(extent[i] / voxel - 1e-6)) + 2 * padding;
  grid.values.assign(grid.count(), 0);
  return grid;
}

// `slack` in voxels dilates the silhouettes, so that a coarse grid loses no voxels.
void carve(const Carving& carving, std::span<const HalfSpace> within, double slack, VoxelGrid<uint8_t>& grid) {
  grid.each([&](int x, int y, int z) {
    const Vec3d p = grid.centre(x, y, z);
    grid.values[grid.index(x, y, z)] =
        std::ranges::all_of(within,
                            [&](const HalfSpace& half) { return dot(half.normal, p) <= half.offset + slack * grid.cell; }) &&
        carving.inside(p, grid.cell, slack * grid.cell);
  });
}

// Keeps the largest face-connected component; the first on a tie.
void keep_largest(VoxelGrid<uint8_t>& grid) {
  const ConnectedComponents parts = connected_components(grid, [&](size_t i) { return grid.values[i] > 0; });
  const auto largest = std::ranges::max_element(parts.members, {}, &std::vector<size_t>::size) - parts.members.begin();
  for (size_t i = 0; i < grid.values.size(); ++i)
    if (parts.label[i] != uint32_t(largest)) grid.values[i] = 0;
}

Bounds3 occupied(const VoxelGrid<uint8_t>& grid) {
  Bounds3 bounds;
  grid.each_in_order([&](int x, int y, int z) {
    if (!grid.at(x, y, z)) return;
    bounds.extend(grid.centre(x, y, z) - (0.5 * grid.cell) * Vec3d{1, 1, 1});
    bounds.extend(grid.centre(x, y, z) + (0.5 * grid.cell) * Vec3d{1, 1, 1});
  });
  return bounds;
}

void blur(VoxelGrid<float>& grid) {
  const size_t stride[3] = {1, size_t(grid.size[0]), size_t(grid.size[0]) * size_t(grid.size[1])};
  std::vector<float> out(grid.values.size());
  for (int pass = 0; pass < kBlurPasses; ++pass)
    for (size_t axis = 0; axis < 3; ++axis) {
      grid.each([&](int x, int y, int z) {
        const int at[3] = {x, y, z};
        const size_t i = grid.index(x, y, z);
        const float before = at[axis] > 0 ? grid.values[i - stride[axis]] : 0;
        const float after = at[axis] + 1 < grid.size[axis] ? grid.values[i + stride[axis]] : 0;
        out[i] = (before + grid.values[i] + after) / 3;
      });
      std::swap(grid.values, out);
    }
}

}  // namespace

VisualHull::VisualHull(std::span<const Silhouette> silhouettes, const HullDesc& desc) {
  if (silhouettes.size() < desc.rule.fewest_views) return;
  const Carving carving(silhouettes, desc.rule, true);
  const double r = desc.reach;
  VoxelGrid<uint8_t> coarse = grid_over({{-r, -r, -r}, {r, r, r}}, kCoarse, 0);
  carve(carving, desc.within, 0.9, coarse);
  const Bounds3 rough = occupied(coarse);
  if (rough.empty()) return;
  VoxelGrid<uint8_t> fine = grid_over(rough, desc.resolution, kPadding);
  carve(carving, desc.within, 0, fine);
  if (desc.one_piece) keep_largest(fine);
  bounds_ = occupied(fine);
  if (bounds_.empty()) return;
  Vec3d mean{};
  for (const Silhouette& s : silhouettes)
    mean += normalized(s.view.centre_in_world() - bounds_.centre()) / double(silhouettes.size());
  one_sidedness_ = length(mean);
  if (one_sidedness_ > desc.most_one_sided) return;
  grid_ = {fine.origin, fine.cell, fine.size, {fine.values.begin(), fine.values.end()}};
  carved_ = std::move(fine);
  blur(grid_);
}

Vec3d VisualHull::inwards(const Vec3d& p) const {
  Vec3d gradient{};
  for (size_t i = 0; i < 3; ++i) {
    Vec3d step{};
    step[i] = 1.5 * grid_.cell;
    gradient[i] = double(occupancy(p + step) - occupancy(p - step));
  }
  return gradient;
}

std::vector<ShapePoint> VisualHull::surface() const {
  std::vector<ShapePoint> points;
  grid_.each_in_order([&](int x, int y, int z) {
    const Vec3d centre = grid_.centre(x, y, z);
    const double inside = double(grid_.at(x, y, z));
    if (inside < 0.1 || inside > 0.9) return;
    const Vec3d gradient = inwards(centre);
    const double steepness = length(gradient) / (3 * grid_.cell);
    if (!(steepness > 1e-3 / grid_.cell)) return;
    const double out = (inside - double(kSurfaceLevel)) / steepness;
    if (std::abs(out) > 0.5 * grid_.cell) return;
    const Vec3d normal = -1.0 * normalized(gradient);
    points.push_back({centre + out * normal, normal});
  });
  return points;
}

float VisualHull::occupancy(const Vec3d& p) const {
  const Vec3d q = (p - grid_.origin) / grid_.cell - Vec3d{0.5, 0.5, 0.5};
  const int x = int(std::floor(q.x)), y = int(std::floor(q.y)), z = int(std::floor(q.z));
  if (x < 0 || y < 0 || z < 0 || !grid_.has(x + 1, y + 1, z + 1)) return 0;
  const float u = float(q.x - x), v = float(q.y - y), w = float(q.z - z);
  const size_t row = size_t(grid_.size[0]), slice = row * size_t(grid_.size[1]);
  const float* f = grid_.values.data() + grid_.index(x, y, z);
  const auto across = [&](const float* g) {
    return (1 - v) * ((1 - u) * g[0] + u * g[1]) + v * ((1 - u) * g[row] + u * g[row + 1]);
  };
  return (1 - w) * across(f) + w * across(f + slice);
}

std::optional<HullHit> VisualHull::first_hit(const Vec3d& origin, const Vec3d& direction) const {
  if (empty()) return std::nullopt;
  const Vec3d d = normalized(direction);
  const Vec3d low_corner = grid_.origin, high_corner = grid_.high();
  double near = 0, far = 1e300;
  for (size_t i = 0; i < 3; ++i) {
    if (std::abs(d[i]) < 1e-12) {
      if (origin[i] < low_corner[i] || origin[i] > high_corner[i]) return std::nullopt;
      continue;
    }
    const double a = (low_corner[i] - origin[i]) / d[i], b = (high_corner[i] - origin[i]) / d[i];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  for (double t = near; t < far; t += 0.5 * grid_.cell) {
    if (occupancy(origin + t * d) < kSurfaceLevel) continue;
    double low = std::max(0.0, t - 0.5 * grid_.cell), high = t;
    for (int step = 0; step < 10; ++step) {
      const double middle = 0.5 * (low + high);
      (occupancy(origin + middle * d) < kSurfaceLevel ? low : high) = middle;
    }
    const Vec3d hit = origin + high * d;
    const Vec3d outwards = -1.0 * inwards(hit);
    if (!(length(outwards) > 1e-6) || dot(outwards, d) >= 0) return std::nullopt;
    return HullHit{high / length(direction), normalized(outwards)};
  }
  return std::nullopt;
}

std::vector<std::vector<uint8_t>> silhouettes_of(const VisualHull& hull, std::span<const View> views) {
  std::vector<std::vector<uint8_t>> out(views.size());
  parallel_for(views.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    out[v] = mask_of_rays(
        views[v], [&](size_t, const Vec3d& eye, const Vec3d& direction) { return hull.first_hit(eye, direction).has_value(); });
  });
  throw_if_interrupted();
  return out;
}

}  // namespace vitrine
