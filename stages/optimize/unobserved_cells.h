// A surface in square cells: which of them photos see, which they look through, and the smoothest continuation of the colours
// into those that none sees (Laplace's equation), as far as a short way from the last one seen.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/learn/trainer/capture.h"

namespace vitrine {

inline constexpr size_t kUnseenLevel = 1;  // of the photos' pyramids

// A training photo, and the z-depth [h,w] of what was trained, as it sees it; 0 = nothing there.
struct SeenPhoto {
  const PhotoLevel* photo;
  std::vector<float> zdepth;
};

// What a photo says about a place: `zdepth` as it has it there, 0 = nothing; `place_z` of the place.
enum class Sight : uint8_t { Unseen, Seen, Through };

struct CellSurface {
  int columns = 0, rows = 0;
  bool round = false;  // the first column follows the last
  std::function<Vec3d(double column, double row)> place;
  std::function<Sight(double place_z, double zdepth)> sight;
};

class UnobservedCells {
 public:
  // `reach`: cells from the last one seen.
  UnobservedCells(const CellSurface& surface, std::span<const SeenPhoto> photos, double reach);

  // Squares of cells to be guessed, as large as they come: visit(centre, cells along a side, linear colour).
  void for_guessed(const std::function<void(const Vec3d&, int, const Vec3d&)>& visit) const;

 private:
  struct Cell {
    Sight sight = Sight::Unseen;
    bool reached = false;  // seen, or not far from it
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
