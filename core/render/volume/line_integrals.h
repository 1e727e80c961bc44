// X-ray pictures of a set of 3D Gaussians: line integrals of their sum, which needs no order, forward and reverse, in float,
// eight rays a vector, on all threads. Same bytes for any number of threads: a pixel adds its Gaussians in their order, a
// Gaussian its tiles in their order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/render/volume/gaussian3.h"
#include "core/render/volume/volume_ray.h"

namespace vitrine {

// Gaussians are left out of tiles whose rays all pass them at more than this many standard deviations: the error of a ray is
// at most exp(-cutoff^2 / 2) of the sum of the omitted Gaussians' integrals through their means (2.2e-3 of each).
inline constexpr double kVolumeCutoff = 3.5;

class LineIntegrals {
 public:
  // Finds the tiles of each Gaussian. `rays` and `gaussians` must outlive it.
  LineIntegrals(const RayTiles& rays, std::span<const Gaussian3f> gaussians, double cutoff = kVolumeCutoff);

  void forward(std::span<float> values) const;  // [h, w]
  // Adds the gradient for dL/d(integral) `gradient` [h, w].
  void backward(std::span<const float> gradient, std::span<Gaussian3Gradient> out) const;

  size_t instances() const { return tile_of_.size(); }  // pairs of Gaussian and tile

  struct Prepared {
    Mat3f matrix;  // W
    Vec3f mean;    // relative to the pivot
    float peak;    // rho sqrt(2 pi)
  };

  // The pairs, for other sums over the same tiles: an instance is a Gaussian in a tile, numbered by Gaussian, then tile.
  const RayTiles& rays() const { return rays_; }
  std::span<const Gaussian3f> gaussians() const { return gaussians_; }
  const Prepared& prepared_at(uint32_t gaussian) const { return prepared_[gaussian]; }
  uint32_t gaussian_of(uint32_t instance) const { return gaussian_of_[instance]; }
  std::span<const uint32_t> instances_of_tile(size_t tile) const {
    return std::span(tile_instances_).subspan(tile_first_[tile], tile_first_[tile + 1] - tile_first_[tile]);
  }
  size_t first_instance(size_t gaussian) const { return first_[gaussian]; }  // up to gaussians().size()

 private:
  const RayTiles& rays_;
  std::span<const Gaussian3f> gaussians_;
  std::vector<Prepared> prepared_;        // [gaussians]
  std::vector<size_t> first_;             // [gaussians + 1] into tile_of_
  std::vector<uint32_t> tile_of_;         // [instances] by Gaussian, then tile
  std::vector<uint32_t> gaussian_of_;     // [instances]
  std::vector<size_t> tile_first_;        // [tiles + 1] into tile_instances_
  std::vector<uint32_t> tile_instances_;  // [instances] by tile, then Gaussian
};

}  // namespace vitrine
