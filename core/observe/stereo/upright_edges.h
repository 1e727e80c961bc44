// Where in the plan upright edges stand: every place and height of a scene is asked how much of an upright edge the photos see
// there, and what stands out of its surroundings in the plan at many heights is an edge of a thing.
#pragma once

#include <span>
#include <vector>

#include "core/observe/stereo/edge_field.h"

namespace vitrine {

struct UprightEdge {
  double x = 0, y = 0;
  double strength = 0;  // robust standard deviations out of the surroundings, summed over the levels where it shows
};

class UprightEdges {
 public:
  UprightEdges(std::span<const EdgeField> fields, const Bounds3& about);

  // The strongest first, `most` of them.
  std::vector<UprightEdge> strongest(size_t most) const;
  struct Run {
    double low = 0, high = 0;  // heights
    double total = 0;          // mean strength between them
    double weakest = 0;        // strength between them of the edge that has least of it
  };
  // The heights between which these edges show together.
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
  std::vector<float> votes_;  // [level, y, x] mean over the photos that show it, negative: too few do; then how far it stands out
};

}  // namespace vitrine
