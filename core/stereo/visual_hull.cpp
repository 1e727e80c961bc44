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

struct Grid {
  Vec3d origin;  // corner of voxel (0, 0, 0)
  double voxel;
  int size[3];
  size_t index(int x, int y, int z) const { return (size_t(z) * size_t(size[1]) + size_t(y)) * size_t(size[0]) + size_t(x); }
  Vec3d centre(int x, int y, int z) const { return origin + voxel * Vec3d{x + 0.5, y + 0.5, z + 0.5}; }
};

Grid grid_over(const Bounds3& bounds, int resolution, int padding) {
  const Vec3d extent = bounds.high - bounds.low;
  const double voxel = std::max({extent.x, extent.y, extent.z}) / resolution;
  Grid grid{bounds.low - (padding * voxel) * Vec3d{1, 1, 1}, voxel, {}};
  for (size_t i = 0; i < 3; ++i) grid.size[i] = int(std::ceil(extent[i] / voxel - 1e-6)) + 2 * padding;
  return grid;
}

// 1 where at most the share `desc.dissent` of the photos sees the voxel outside their mask. `slack` in voxels widens the masks,
// so that a coarse grid loses nothing.
std::vector<float> carved(std::span<const HullMask> masks, const Grid& grid, const HullDesc& desc, double slack) {
  std::vector<float> field(size_t(grid.size[0]) * size_t(grid.size[1]) * size_t(grid.size[2]), 0);
  const size_t needed = std::max(desc.fewest_views, size_t(kSeenBy * double(masks.size())));
  parallel_for(size_t(grid.size[2]), 1, [&](size_t z) {
    for (int y = 0; y < grid.size[1]; ++y)
      for (int x = 0; x < grid.size[0]; ++x) {
        const Vec3d centre = grid.centre(x, y, int(z));
        size_t seen = 0, outside = 0;
        for (const HullMask& m : masks) {
          const auto p = image_point(centre, m.view, grid.voxel);
          if (!p) continue;
          const int u = int(p->x), v = int(p->y);
          const float value = m.mask.at(u, v);
          if (value < 0) continue;
          bool inside = value >= 0.5f;
          if (const int r = int(std::ceil(slack * grid.voxel * m.view.intrinsics.fx / p->z)); !inside && slack > 0)
            for (int dy = -r; dy <= r && !inside; ++dy)
              for (int dx = -r; dx <= r && !inside; ++dx)
                inside = m.mask.at(std::clamp(u + dx, 0, m.mask.width() - 1), std::clamp(v + dy, 0, m.mask.height() - 1)) >= 0.5f;
          if (!inside && !m.zdepth.empty()) {
            const float z = m.zdepth.at(u, v);
            if (z > 0 && z < kInFront * float(p->z)) continue;
          }
          ++seen;
          outside += !inside;
        }
        if (seen >= needed && double(outside) <= desc.dissent * double(seen)) field[grid.index(x, y, int(z))] = 1;
      }
  });
  return field;
}

// Leaves the largest part whose voxels share faces; of equally large ones the first.
void keep_largest(std::vector<float>& field, const Grid& grid) {
  const ptrdiff_t stride[3] = {1, grid.size[0], ptrdiff_t(grid.size[0]) * grid.size[1]};
  std::vector<uint32_t> part(field.size(), 0);
  std::vector<size_t> sizes{0}, stack;
  for (size_t seed = 0; seed < field.size(); ++seed) {
    if (field[seed] == 0 || part[seed] != 0) continue;
    const auto label = uint32_t(sizes.size());
    sizes.push_back(0);
    part[seed] = label;
    stack.push_back(seed);
    while (!stack.empty()) {
      const size_t i = stack.back();
      stack.pop_back();
      ++sizes[label];
      const size_t row = size_t(grid.size[0]), at[3] = {i % row, i / row % size_t(grid.size[1]), i / size_t(stride[2])};
      for (size_t axis = 0; axis < 3; ++axis)
        for (int step : {-1, 1}) {
          if (step < 0 ? at[axis] == 0 : at[axis] + 1 == size_t(grid.size[axis])) continue;
          const auto j = size_t(ptrdiff_t(i) + step * stride[axis]);
          if (field[j] == 0 || part[j] != 0) continue;
          part[j] = label;
          stack.push_back(j);
        }
    }
  }
  const auto largest = uint32_t(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
  for (size_t i = 0; i < field.size(); ++i)
    if (part[i] != largest) field[i] = 0;
}

Bounds3 occupied(const std::vector<float>& field, const Grid& grid) {
  Bounds3 bounds;
  for (int z = 0; z < grid.size[2]; ++z)
    for (int y = 0; y < grid.size[1]; ++y)
      for (int x = 0; x < grid.size[0]; ++x)
        if (field[grid.index(x, y, z)] > 0) {
          bounds.extend(grid.centre(x, y, z) - (0.5 * grid.voxel) * Vec3d{1, 1, 1});
          bounds.extend(grid.centre(x, y, z) + (0.5 * grid.voxel) * Vec3d{1, 1, 1});
        }
  return bounds;
}

void blur(std::vector<float>& field, const Grid& grid, int passes) {
  const size_t stride[3] = {1, size_t(grid.size[0]), size_t(grid.size[0]) * size_t(grid.size[1])};
  std::vector<float> out(field.size());
  for (int pass = 0; pass < passes; ++pass)
    for (int axis = 0; axis < 3; ++axis) {
      parallel_for(size_t(grid.size[2]), 4, [&](size_t z) {
        for (int y = 0; y < grid.size[1]; ++y)
          for (int x = 0; x < grid.size[0]; ++x) {
            const int at[3] = {x, y, int(z)};
            const size_t i = grid.index(x, y, int(z));
            const float before = at[axis] > 0 ? field[i - stride[axis]] : 0;
            const float after = at[axis] + 1 < grid.size[axis] ? field[i + stride[axis]] : 0;
            out[i] = (before + field[i] + after) / 3;
          }
      });
      std::swap(field, out);
    }
}

}  // namespace

VisualHull::VisualHull(std::span<const HullMask> masks, const HullDesc& desc) {
  if (masks.size() < desc.fewest_views) return;
  const double r = desc.reach;
  const Grid coarse = grid_over({{-r, -r, -r}, {r, r, r}}, kCoarse, 0);
  const Bounds3 rough = occupied(carved(masks, coarse, desc, 0.9), coarse);
  if (rough.empty()) return;
  Grid fine = grid_over(rough, desc.resolution, kPadding);
  std::vector<float> field = carved(masks, fine, desc, 0);
  if (desc.one_piece) keep_largest(field, fine);
  bounds_ = occupied(field, fine);
  if (bounds_.empty()) return;
  Vec3d mean{};
  for (const HullMask& m : masks) mean += normalized(m.view.centre_in_world() - bounds_.centre()) / double(masks.size());
  one_sidedness_ = length(mean);
  if (one_sidedness_ > desc.most_one_sided) return;
  blur(field, fine, desc.blur_passes);
  grid_ = {fine.origin, fine.origin + fine.voxel * Vec3d{double(fine.size[0]), double(fine.size[1]), double(fine.size[2])}};
  voxel_ = fine.voxel;
  std::copy(std::begin(fine.size), std::end(fine.size), std::begin(size_));
  field_ = std::move(field);
  if (!desc.flat_faces) return;
  if (const std::optional<BoxFit> fit = fit_box(masks, bounds_)) {
    box_ = fit->box;
    return;
  }
  const std::vector<HullSurfacePoint> points = surface();
  turned_ = solids_of_revolution(masks, points, voxel_);
  if (turned_.empty()) faces_ = flat_faces(points, voxel_);  // which finds facets on round things as well
}

Vec3d VisualHull::inwards(const Vec3d& p) const {
  Vec3d gradient{};
  for (size_t i = 0; i < 3; ++i) {
    Vec3d step{};
    step[i] = 1.5 * voxel_;
    gradient[i] = double(occupancy(p + step) - occupancy(p - step));
  }
  return gradient;
}

std::vector<HullSurfacePoint> VisualHull::surface() const {
  std::vector<HullSurfacePoint> points;
  for (int z = 0; z < size_[2]; ++z)
    for (int y = 0; y < size_[1]; ++y)
      for (int x = 0; x < size_[0]; ++x) {
        const Vec3d centre = grid_.low + voxel_ * Vec3d{x + 0.5, y + 0.5, z + 0.5};
        const double inside = double(field_[(size_t(z) * size_t(size_[1]) + size_t(y)) * size_t(size_[0]) + size_t(x)]);
        if (inside < 0.1 || inside > 0.9) continue;
        const Vec3d gradient = inwards(centre);
        const double steepness = length(gradient) / (3 * voxel_);
        if (!(steepness > 1e-3 / voxel_)) continue;
        const double out = (inside - double(kSurfaceLevel)) / steepness;
        if (std::abs(out) > 0.5 * voxel_) continue;
        const Vec3d normal = -1.0 * normalized(gradient);
        points.push_back({centre + out * normal, normal});
      }
  return points;
}

float VisualHull::occupancy(const Vec3d& p) const {
  const Vec3d q = (p - grid_.low) / voxel_ - Vec3d{0.5, 0.5, 0.5};
  const int x = int(std::floor(q.x)), y = int(std::floor(q.y)), z = int(std::floor(q.z));
  if (x < 0 || y < 0 || z < 0 || x + 1 >= size_[0] || y + 1 >= size_[1] || z + 1 >= size_[2]) return 0;
  const float u = float(q.x - x), v = float(q.y - y), w = float(q.z - z);
  const size_t row = size_t(size_[0]), slice = row * size_t(size_[1]);
  const float* f = field_.data() + (size_t(z) * size_t(size_[1]) + size_t(y)) * row + size_t(x);
  const auto across = [&](const float* g) {
    return (1 - v) * ((1 - u) * g[0] + u * g[1]) + v * ((1 - u) * g[row] + u * g[row + 1]);
  };
  return (1 - w) * across(f) + w * across(f + slice);
}

std::optional<HullHit> VisualHull::first_hit(const Vec3d& origin, const Vec3d& direction) const {
  if (empty()) return std::nullopt;
  if (box_) return vitrine::first_hit(*box_, origin, direction);
  const Vec3d d = normalized(direction);
  double near = 0, far = 1e300;
  for (size_t i = 0; i < 3; ++i) {
    if (std::abs(d[i]) < 1e-12) {
      if (origin[i] < grid_.low[i] || origin[i] > grid_.high[i]) return std::nullopt;
      continue;
    }
    const double a = (grid_.low[i] - origin[i]) / d[i], b = (grid_.high[i] - origin[i]) / d[i];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  for (double t = near; t < far; t += 0.5 * voxel_) {
    if (occupancy(origin + t * d) < kSurfaceLevel) continue;
    double low = std::max(0.0, t - 0.5 * voxel_), high = t;
    for (int step = 0; step < 10; ++step) {
      const double middle = 0.5 * (low + high);
      (occupancy(origin + middle * d) < kSurfaceLevel ? low : high) = middle;
    }
    const Vec3d hit = origin + high * d;
    const Vec3d outwards = -1.0 * inwards(hit);
    if (!(length(outwards) > 1e-6) || dot(outwards, d) >= 0) return std::nullopt;
    const HullSurfacePoint carved{hit, normalized(outwards)};
    const HullSurfacePoint met = on_solid(turned_, carved, voxel_).value_or(carved);
    const FlatFace* face = face_of(faces_, met, voxel_);
    return HullHit{high / length(direction), face != nullptr && dot(face->normal, d) < 0 ? face->normal : met.normal};
  }
  return std::nullopt;
}

}  // namespace vitrine
