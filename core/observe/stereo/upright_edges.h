// Detects vertical edges in the floor plan: for every plan cell and height, the edge strength over all photos; cells that exceed
// their surroundings at many heights are edges of an object.
#pragma once

#include <span>
#include <vector>

#include "core/observe/stereo/edge_field.h"
#include "core/scene/shape/box.h"

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

// Detects upright boxes from photo edges alone: display cases, aquaria, crates. They have no masks, glass has no texture, and
// stereo does not find it. A vertical edge projects to one point of the floor plan from every camera. Four of them at the corners
// of a rectangle, of equal height, under a rim that is an edge on all sides, do not occur by chance in posters or patterns.
struct StandingBox {
  Box box;  // its third axis points up (+z)
  // Strength of the vertical edges relative to the surrounding plan, and of the rim relative to other heights: robust standard
  // deviations. `posts`: summed over height levels, mean of the four edges.
  double posts = 0, rim = 0;
};

// Best first, with vertical edges of at least `least_posts`; boxes may overlap. `about`: search bounds in plan; boxes may be
// higher. The lower end of a box is where its vertical edges become visible. Returns nothing for fewer than eight photos; large
// photos are reduced to 640 pixels.
std::vector<StandingBox> standing_boxes(std::span<const EdgePhoto> photos, const Bounds3& about, double least_posts);

// Maximises the edge strength along the vertical edges and the rim from `start`, a nearly correct upright box. The height of
// its foot stays fixed, since the surface under it has edges as well.
Box drawn_to_edges(const Box& start, std::span<const EdgePhoto> photos);

}  // namespace vitrine
