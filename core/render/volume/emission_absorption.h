// Pictures of a volume of 3D Gaussians that absorb and emit, forward and reverse: the light of a ray is the integral of
// colour(t) density(t) exp(-optical depth before t), where colour is the mean of the Gaussians', weighted by their densities.
// In float, eight rays a vector, on all threads, in no order of the Gaussians, which may overlap in any way.
//
// Each tile's rays are cut into cells at the same distances (cell_nodes.h). Optical depth and emission of a cell are closed forms
// per Gaussian and add up; cells follow each other front to back (kernels/cells.h). Same bytes for any number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/render/volume/kernels/profile.h"
#include "core/render/volume/line_integrals.h"

namespace vitrine {

class EmissionAbsorption {
 public:
  static constexpr int kCells = 32, kMostCells = 64;

  // Finds the tiles of each Gaussian and the cells of each tile. `rays` and `gaussians` must outlive it; densities absorb per
  // unit of length. `cells`: 2 to kMostCells per ray; the error falls with their square.
  EmissionAbsorption(const RayTiles& rays, std::span<const Gaussian3f> gaussians, int cells = kCells,
                     double cutoff = kVolumeCutoff);

  // `colors`: radiance of each Gaussian where it is opaque. `light` [h, w].
  void forward(std::span<const Vec3f> colors, std::span<VolumeLightf> light) const;
  // Adds the gradients for dL/d(light) `gradient` [h, w], the cells held where they are.
  void backward(std::span<const Vec3f> colors, std::span<const VolumeLightf> gradient, std::span<Gaussian3Gradient> out,
                std::span<Vec3f> out_colors) const;

  // Borders between the cells of a tile: distances from the points of its rays that are nearest to the pivot.
  std::span<const float> nodes(size_t tile) const {
    return std::span(nodes_).subspan(tile * size_t(cells_ - 1), size_t(cells_ - 1));
  }
  size_t instances() const { return lines_.instances(); }

 private:
  // The cells that the Gaussian of an instance reaches: [first, last].
  struct Reach {
    uint8_t first, last;
  };
  void place_cells(size_t tile);

  int cells_;
  LineIntegrals lines_;
  std::vector<float> nodes_;  // [tiles, cells - 1]
  std::vector<Reach> reach_;  // [instances]
};

}  // namespace vitrine
