#include "stages/optimize/plane_inpainting.h"

#include <algorithm>
#include <optional>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

constexpr int kSweeps = 300;
constexpr double kOverrelaxed = 1.8;
constexpr int kLargest = 16;  // largest side in cells of a surfel in a region without detail

}  // namespace

UnobservedCells::UnobservedCells(const CellSurface& surface, std::span<const SeenPhoto> photos, double reach)
    : surface_(surface), cells_(size_t(surface.columns) * size_t(surface.rows)) {
  const size_t columns = size_t(surface_.columns);
  parallel_for(cells_.size(), 256, [&](size_t c) {
    cells_[c] = looked_at(photos, surface_.place(double(c % columns) + 0.5, double(c / columns) + 0.5));
  });
  close_gaps(reach);
}

UnobservedCells::Cell UnobservedCells::looked_at(std::span<const SeenPhoto> photos, const Vec3d& place) const {
  Cell cell;
  double weights = 0;
  for (const SeenPhoto& seen : photos) {
    const View& view = seen.photo->view;
    const std::optional<ImagePoint> q = image_point(place, view);
    if (!q) continue;
    const size_t pixel = size_t(q->y) * size_t(view.intrinsics.width) + size_t(q->x);
    const Sight sight = surface_.sight(q->z, double(seen.zdepth[pixel]));
    if (sight == Sight::Unseen || (sight == Sight::Through && cell.sight == Sight::Seen)) continue;
    cell.sight = sight;
    if (sight == Sight::Through) continue;
    const double weight = 1 / (q->z * q->z);
    Vec3d linear = cast<double>(linear_at(*seen.photo, pixel));
    if (seen.medium) linear = without_medium(*seen.medium, linear, length(place - view.centre_in_world()));
    cell.linear += weight * linear;
    weights += weight;
  }
  if (weights > 0) cell.linear = cell.linear / weights;
  return cell;
}

template <class Visit>
void UnobservedCells::for_neighbours(size_t cell, const Visit& visit) const {
  const size_t columns = size_t(surface_.columns), x = cell % columns, y = cell / columns;
  if (x > 0)
    visit(cell - 1);
  else if (surface_.round)
    visit(cell + columns - 1);
  if (x + 1 < columns)
    visit(cell + 1);
  else if (surface_.round)
    visit(cell + 1 - columns);
  if (y > 0) visit(cell - columns);
  if (y + 1 < size_t(surface_.rows)) visit(cell + columns);
}

// Fills unseen cells with the colour of the nearest seen cell, then solves Laplace's equation.
void UnobservedCells::close_gaps(double reach) {
  std::vector<size_t> front, gaps;
  for (size_t c = 0; c < cells_.size(); ++c)
    if ((cells_[c].reached = cells_[c].sight == Sight::Seen)) front.push_back(c);
  for (int way = 0; way < reach; ++way) {
    std::vector<size_t> next;
    for (size_t from : front)
      for_neighbours(from, [&](size_t c) {
        if (cells_[c].reached || cells_[c].sight != Sight::Unseen) return;
        cells_[c].reached = true;
        cells_[c].linear = cells_[from].linear;
        next.push_back(c);
      });
    gaps.insert(gaps.end(), next.begin(), next.end());
    front = std::move(next);
  }
  std::sort(gaps.begin(), gaps.end());
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (size_t c : gaps) {
      Vec3d sum{};
      double count = 0;
      for_neighbours(c, [&](size_t n) {
        if (cells_[n].reached) sum += cells_[n].linear, count += 1;
      });
      cells_[c].linear += kOverrelaxed * (sum / count - cells_[c].linear);
    }
}

void UnobservedCells::for_guessed(const std::function<void(const Vec3d&, int, const Vec3d&)>& visit) const {
  const int columns = surface_.columns, rows = surface_.rows;
  std::vector<uint8_t> open(cells_.size());
  for (size_t c = 0; c < cells_.size(); ++c) open[c] = cells_[c].sight == Sight::Unseen && cells_[c].reached;
  for (int side = kLargest; side > 0; side /= 2)
    for (int y = 0; y + side <= rows; y += side)
      for (int x = 0; x + side <= columns; x += side) {
        const auto all = [&](const auto& body) {
          for (int v = y; v < y + side; ++v)
            for (int u = x; u < x + side; ++u)
              if (!body(size_t(v) * size_t(columns) + size_t(u))) return false;
          return true;
        };
        if (!all([&](size_t c) { return open[c] != 0; })) continue;
        Vec3d linear{};
        all([&](size_t c) {
          linear += cells_[c].linear / double(side * side);
          open[c] = 0;
          return true;
        });
        visit(surface_.place(x + 0.5 * side, y + 0.5 * side), side, linear);
      }
}

}  // namespace vitrine
