// Detects upright boxes from photo edges alone: display cases, aquaria, crates. They have no masks, glass has no texture, and
// stereo does not find it. A vertical edge projects to one point of the floor plan from every camera. Four of them at the corners
// of a rectangle, of equal height, under a rim that is an edge on all sides, do not occur by chance in posters or patterns.
#pragma once

#include <span>
#include <vector>

#include "core/scene/shape/box.h"
#include "core/observe/stereo/edge_field.h"

namespace vitrine {

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
