#include "core/stereo/visual_hull.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/camera/projection.h"
#include "core/stereo/box_fit.h"

namespace vitrine {

namespace {

constexpr int kCoarse = 48;            // first look at the whole cube
constexpr int kPadding = 4;            // voxels around what is left, so that the blurred surface closes
constexpr float kInFront = 0.98f;      // a thing nearer than this part of a point's depth hides it
constexpr float kSurfaceLevel = 0.5f;  // of occupancy: the surface
constexpr double kSeenBy = 0.35;       // share of the photos that must see a voxel: a hull of few photos is no hull

VoxelGrid<float> grid_over(const Bounds3& bounds, int resolution, int padding) {
  const Vec3d extent = bounds.high - bounds.low;
  const double voxel = std::max({extent.x, extent.y, extent.z}) / resolution;
  VoxelGrid<float> grid{bounds.low - (padding * voxel) * Vec3d{1, 1, 1}, voxel, {}, {}};
  for (size_t i = 0; i < 3; ++i) grid.size[i] = int(std::ceil(extent[i] / voxel - 1e-6)) + 2 * padding;
  grid.values.assign(grid.count(), 0.f);
  return grid;
}

// 1 where at most the share `desc.dissent` of the photos sees the voxel outside their mask. `slack` in voxels widens the masks,
// so that a coarse grid loses nothing.
void carve(std::span<const HullMask> masks, const HullDesc& desc, double slack, VoxelGrid<float>& grid) {
  const size_t needed = std::max(desc.fewest_views, size_t(kSeenBy * double(masks.size())));
  grid.each([&](int x, int y, int z) {
    const Vec3d centre = grid.centre(x, y, z);
    size_t seen = 0, outside = 0;
    for (const HullMask& m : masks) {
      const auto p = image_point(centre, m.view, grid.cell);
      if (!p) continue;
      const int u = int(p->x), v = int(p->y);
      const float value = m.mask.at(u, v);
      if (value < 0) continue;
      bool inside = value >= 0.5f;
      if (const int r = int(std::ceil(slack * grid.cell * m.view.intrinsics.fx / p->z)); !inside && slack > 0)
        for (int dy = -r; dy <= r && !inside; ++dy)
          for (int dx = -r; dx <= r && !inside; ++dx)
            inside = m.mask.at(std::clamp(u + dx, 0, m.mask.width() - 1), std::clamp(v + dy, 0, m.mask.height() - 1)) >= 0.5f;
      if (!inside && !m.zdepth.empty()) {
        const float in_front = m.zdepth.at(u, v);
        if (in_front > 0 && in_front < kInFront * float(p->z)) continue;
      }
      ++seen;
      outside += !inside;
    }
    if (seen >= needed && double(outside) <= desc.dissent * double(seen)) grid.values[grid.index(x, y, z)] = 1;
  });
}

// Leaves the largest part whose voxels share faces; of equally large ones the first.
void keep_largest(VoxelGrid<float>& grid) {
  const ConnectedComponents parts = connected_components(grid, [&](size_t i) { return grid.values[i] > 0; });
  const auto largest = std::ranges::max_element(parts.members, {}, &std::vector<size_t>::size) - parts.members.begin();
  for (size_t i = 0; i < grid.values.size(); ++i)
    if (parts.label[i] != uint32_t(largest)) grid.values[i] = 0;
}

Bounds3 occupied(const VoxelGrid<float>& grid) {
  Bounds3 bounds;
  grid.each_in_order([&](int x, int y, int z) {
    if (!(grid.at(x, y, z) > 0)) return;
    bounds.extend(grid.centre(x, y, z) - (0.5 * grid.cell) * Vec3d{1, 1, 1});
    bounds.extend(grid.centre(x, y, z) + (0.5 * grid.cell) * Vec3d{1, 1, 1});
  });
  return bounds;
}

void blur(VoxelGrid<float>& grid, int passes) {
  const size_t stride[3] = {1, size_t(grid.size[0]), size_t(grid.size[0]) * size_t(grid.size[1])};
  std::vector<float> out(grid.values.size());
  for (int pass = 0; pass < passes; ++pass)
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

VisualHull::VisualHull(std::span<const HullMask> masks, const HullDesc& desc) {
  if (masks.size() < desc.fewest_views) return;
  const double r = desc.reach;
  VoxelGrid<float> coarse = grid_over({{-r, -r, -r}, {r, r, r}}, kCoarse, 0);
  carve(masks, desc, 0.9, coarse);
  const Bounds3 rough = occupied(coarse);
  if (rough.empty()) return;
  VoxelGrid<float> fine = grid_over(rough, desc.resolution, kPadding);
  carve(masks, desc, 0, fine);
  if (desc.one_piece) keep_largest(fine);
  bounds_ = occupied(fine);
  if (bounds_.empty()) return;
  Vec3d mean{};
  for (const HullMask& m : masks) mean += normalized(m.view.centre_in_world() - bounds_.centre()) / double(masks.size());
  one_sidedness_ = length(mean);
  if (one_sidedness_ > desc.most_one_sided) return;
  blur(fine, desc.blur_passes);
  grid_ = std::move(fine);
  if (!desc.flat_faces) return;
  if (const std::optional<BoxFit> fit = fit_box(masks, bounds_)) {
    box_ = fit->box;
    return;
  }
  const std::vector<HullSurfacePoint> points = surface();
  turned_ = solids_of_revolution(masks, points, grid_.cell);
  if (turned_.empty()) faces_ = flat_faces(points, grid_.cell);  // which finds facets on round things as well
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

std::vector<HullSurfacePoint> VisualHull::surface() const {
  std::vector<HullSurfacePoint> points;
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
  if (box_) return vitrine::first_hit(*box_, origin, direction);
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
    const HullSurfacePoint carved{hit, normalized(outwards)};
    const HullSurfacePoint met = on_solid(turned_, carved, grid_.cell).value_or(carved);
    const FlatFace* face = face_of(faces_, met, grid_.cell);
    return HullHit{high / length(direction), face != nullptr && dot(face->normal, d) < 0 ? face->normal : met.normal};
  }
  return std::nullopt;
}

}  // namespace vitrine
