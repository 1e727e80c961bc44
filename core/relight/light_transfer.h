// Precomputed transfer of light from far away (Sloan, Kautz and Snyder 2002; algorithms 7.7): what a matt place receives of every
// light at once, as long as the light is smooth. With the spherical harmonics Y_k up to degree 3 and the light's coefficients
// L_k = integral of L Y_k over all directions,
//
//   E(x) = sum_k T_k(x) L_k      T_k = integral of V Y_k n.l dl  +  sum over bounces of  integral of (1 - V) n.l rho/pi T_k(x')
//   dl
//
// per channel, x' being the place of the mesh that the ray meets. T_k depends on the scene alone, so whoever has it can turn and
// change the light without a ray: the page of `vitrine view`. Sharp shadows (a sun) are smoothed over some 40 degrees.
//
// Same scene and desc: same bytes, whatever the number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/light/environment.h"
#include "core/math/spherical_harmonics.h"
#include "core/relight/scene_surface.h"
#include "core/scene/layers.h"

namespace vitrine {

inline constexpr int kTransferDegree = 3;
inline constexpr size_t kTransferSize = sh_coefficient_count(kTransferDegree);

// Per coefficient, of the three channels: irradiance for light whose coefficient is 1.
using Transfer = std::array<Vec3f, kTransferSize>;
// L_k of a light, per channel: exact for the map's texels as steps.
using LightHarmonics = std::array<Vec3f, kTransferSize>;

LightHarmonics light_harmonics(const Environment& environment);
// E = sum_k T_k L_k, not below 0.
Vec3f irradiance(const Transfer& transfer, const LightHarmonics& light);

struct TransferDesc {
  int rays = 128;   // of a place, cosine-weighted
  int bounces = 2;  // between surfaces of the scene; 0: direct light alone
  uint64_t seed = 1;
};

class LightTransfer {
 public:
  // Of the vertices of the surface's mesh. `surface` must live as long as this. Throws (core/base/process.h) when the program is
  // asked to stop meanwhile, as all below.
  explicit LightTransfer(const SceneSurface& surface, const TransferDesc& desc = {});

  // Of the surfels of a layer, [surfels]: each at the place of the mesh that it lies on, or of the walls around the scene before
  // which it stands. Where there is neither, light comes from all sides.
  std::vector<Transfer> of_surfels(const SplatLayer& layer) const;

  // What comes along a ray: radiance of the mesh for light whose coefficients are 1, and the share of light from outside.
  struct Arrival {
    Transfer from_scene{};
    float from_outside = 1;
    float distance = 0;  // of the first solid surface; 0: there is none
  };
  Arrival arriving(const Vec3f& origin, const Vec3f& direction) const;

 private:
  struct Place {
    Vec3f origin{}, normal{};
  };
  Transfer gathered(const Place& place, uint64_t stream, bool bounced) const;
  Transfer from_all_sides(const Vec3f& point, uint64_t stream) const;
  // Adds `share` of the radiance that a place of the mesh sends on.
  void add_sent(Transfer& sum, const SurfacePlace& place, float share) const;
  Transfer of_surfel(const SplatLayer& layer, size_t i) const;

  const SceneSurface* surface_;
  TransferDesc desc_;
  std::vector<Transfer> vertices_;  // of the mesh, with all bounces but the last
};

}  // namespace vitrine
