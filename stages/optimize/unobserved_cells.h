// Inpainting of surface cells that no photo sees. Cells seen by photos give the boundary colours of Laplace's equation; cells
// that photos see through stay empty. The solution extends a limited distance from the last seen cell.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/learn/trainer/capture.h"

namespace vitrine {

inline constexpr size_t kUnseenLevel = 1;  // level of the photo pyramids

// A training photo and its z-depth [h,w], rendered from the trained surfels; 0 = no surface.
struct SeenPhoto {
  const PhotoLevel* photo;
  std::vector<float> zdepth;
};

// Visibility of a place in a photo: `place_z` is the depth of the place, `zdepth` the rendered depth there, 0 = no surface.
enum class Sight : uint8_t { Unseen, Seen, Through };

struct CellSurface {
  int columns = 0, rows = 0;
  bool round = false;  // closed: the last column is adjacent to the first
  std::function<Vec3d(double column, double row)> place;
  std::function<Sight(double place_z, double zdepth)> sight;
};

class UnobservedCells {
 public:
  // `reach`: largest distance from a seen cell, in cells.
  UnobservedCells(const CellSurface& surface, std::span<const SeenPhoto> photos, double reach);

  // Visits the unseen cells within reach, merged into the largest squares: visit(centre, side in cells, linear colour).
  void for_guessed(const std::function<void(const Vec3d&, int, const Vec3d&)>& visit) const;

 private:
  struct Cell {
    Sight sight = Sight::Unseen;
    bool reached = false;  // seen, or within reach of a seen cell
    Vec3d linear{};
  };
  Cell looked_at(std::span<const SeenPhoto> photos, const Vec3d& place) const;
  template <class Visit>
  void for_neighbours(size_t cell, const Visit& visit) const;
  void close_gaps(double reach);

  CellSurface surface_;
  std::vector<Cell> cells_;
};

}  // namespace vitrine
