// Boxes that stand upright, found by their edges alone: display cases, aquaria, crates. Nobody has marked them, no texture lies
// on glass, and no stereo sees it. But an upright edge is one point of the plan, wherever one looks from, and four of them at the
// corners of a rectangle, as high as each other, under a rim that is an edge all around: that no poster or pattern does by
// chance.
#pragma once

#include <span>
#include <vector>

#include "core/scene/shape/box.h"
#include "core/observe/stereo/edge_field.h"

namespace vitrine {

struct StandingBox {
  Box box;  // its third axis points up (+z)
  // How far its upright edges stand out of the plan around them, and its rim out of other heights: robust standard deviations, of
  // the posts summed over levels of height and in the mean of the four.
  double posts = 0, rim = 0;
};

// Best first, those with at least so strong upright edges; one may stand in, on or through another. `about`: where to look; boxes
// may be higher. The lower end of a box is only where its upright edges begin to show. Fewer than eight photos show nothing; of
// large ones 640 pixels are looked at.
std::vector<StandingBox> standing_boxes(std::span<const EdgePhoto> photos, const Bounds3& about, double least_posts);

// `start`, nearly right and upright, where the photos together have most edge along its upright edges and its rim. The height of
// its foot stays: what it stands on has edges as well.
Box drawn_to_edges(const Box& start, std::span<const EdgePhoto> photos);

}  // namespace vitrine
