// Borders between the cells of the rays of a tile: close together where light comes from, the same for all rays of the tile.
#pragma once

#include <span>
#include <vector>

namespace vitrine {

// A Gaussian along the rays of a tile on average, as a slab.
struct TileProfile {
  double depth = 0;  // mean optical depth
  double at = 0;     // mean distance along the rays, scene units
  double half = 0;   // of the slab's thickness: sqrt(3) standard deviations along the rays and between them, scene units
};

// The `cells` - 1 borders between cells, ascending; the first cell begins before and the last ends behind all Gaussians. With
// the optical depth A(t) of a mean ray, borders have equal steps of sqrt(visible opacity per length), where opacity is weighted
// by exp(-A / 2) instead of exp(-A) because some rays of the tile see deeper than the mean; a seventh of them are spread evenly.
std::vector<float> cell_nodes(std::span<const TileProfile> profiles, int cells);

}  // namespace vitrine
