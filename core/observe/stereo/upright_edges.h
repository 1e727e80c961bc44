// Detects vertical edges in the floor plan: for every plan cell and height, the edge strength over all photos; cells that exceed
// their surroundings at many heights are edges of an object.
#pragma once

#include <span>
#include <vector>

#include "core/observe/stereo/edge_field.h"

namespace vitrine {

struct UprightEdge {
  double x = 0, y = 0;
  double strength = 0;  // robust standard deviations above the surroundings, summed over the levels where the edge shows
};

class UprightEdges {
 public:
  UprightEdges(std::span<const EdgeField> fields, const Bounds3& about);

  // Strongest first, at most `most`.
  std::vector<UprightEdge> strongest(size_t most) const;
  struct Run {
    double low = 0, high = 0;  // heights
    double total = 0;          // mean strength between them
    double weakest = 0;        // strength between them of the weakest edge
  };
  // The heights between which all these edges show.
  Run together(std::span<const UprightEdge> edges) const;
  double cell() const { return cell_; }

 private:
  size_t index(size_t x, size_t y, size_t level) const { return (level * ny_ + y) * nx_ + x; }
  double height(double level) const { return low_.z + level * step_; }
  void vote(std::span<const EdgeField> fields);
  void stand_out();

  Vec3d low_;
  double cell_ = 0, step_ = 0;
  size_t nx_ = 0, ny_ = 0, levels_ = 0;
  // [level, y, x] mean over the photos that see the cell, negative: too few; after stand_out() the excess over the surroundings.
  std::vector<float> votes_;
};

}  // namespace vitrine
