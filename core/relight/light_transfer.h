// What a matt place receives of every light from far away, found once (precomputed transfer; Sloan, Kautz and Snyder 2002;
// algorithms 7.7). Who has it can turn and change the light without a ray: the page of `vitrine view`.
//
//   E(x) = sum_c V_c(x) n.d_c F_c + sum_k T_k(x) L_k
//
// Direct light: the sphere in 576 cells of the octahedral map, V_c whether a ray into the cell leaves the scene, F_c what the
// light sends out of the cell (radiance times solid angle) and d_c where in it from, in the mean. Light from the scene: harmonics
// Y_k up to degree 3 with the light's coefficients L_k = integral of L Y_k over all directions,
//   T_k = integral of (1 - V) n.l rho/pi (T_k + integral of V Y_k n.l')(x') dl
// per channel, x' being the place of the mesh that a ray meets. Edges of shadows are soft over a cell, some 9 degrees.
//
// Same scene and desc: same bytes, whatever the number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/light/environment.h"
#include "core/math/spherical_harmonics.h"
#include "core/relight/scene_surface.h"
#include "core/scene/layers.h"

namespace vitrine {

inline constexpr int kTransferDegree = 3;
inline constexpr size_t kTransferSize = sh_coefficient_count(kTransferDegree);

// Per coefficient, of the three channels: what arrives, or is sent on, for light whose coefficient is 1.
using Transfer = std::array<Vec3f, kTransferSize>;
// L_k of a light, per channel: exact for the map's texels as steps.
using LightHarmonics = std::array<Vec3f, kTransferSize>;

LightHarmonics light_harmonics(const Environment& environment);

inline constexpr int kCellSide = 24;
inline constexpr size_t kCells = size_t(kCellSide) * size_t(kCellSide);
struct CellLight {
  std::array<Vec3f, kCells> flux{};       // F_c
  std::array<Vec3f, kCells> direction{};  // d_c, unit
};
CellLight cell_light(const Environment& environment);

// Of a matt place.
struct ReceivedLight {
  Vec3f normal{};  // 0: no side of its own, light counts from all, by a quarter (pi times the mean over the sphere)
  std::array<uint32_t, kCells / 32> open{};  // bit c: V_c
  Transfer bounced{};
};
// E, not below 0.
Vec3f irradiance(const ReceivedLight& received, const CellLight& cells, const LightHarmonics& harmonics);

struct TransferDesc {
  int rays = 64;    // of a place, cosine-weighted, for light from the scene; and one into each cell
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
  std::vector<ReceivedLight> of_surfels(const SplatLayer& layer) const;

  // What comes along a ray: radiance of the mesh for light whose coefficients are 1, and the share of light from outside.
  struct Arrival {
    Transfer from_scene{};
    float from_outside = 1;
    float distance = 0;  // of the first solid surface; 0: there is none
  };
  Arrival arriving(const Vec3f& origin, const Vec3f& direction) const;
  const SceneSurface& surface() const { return *surface_; }

 private:
  struct Place {
    Vec3f origin{}, normal{};
  };
  Transfer gathered(const Place& place, uint64_t stream, bool direct, bool bounced) const;
  ReceivedLight received(const Place& place, uint64_t stream) const;
  // Adds `share` of the radiance that a place of the mesh sends on.
  void add_sent(Transfer& sum, const SurfacePlace& place, float share) const;
  std::optional<Place> place_of(const Vec3f& mean, const Vec3f& normal) const;
  ReceivedLight of_surfel(const SplatLayer& layer, size_t i) const;

  const SceneSurface* surface_;
  TransferDesc desc_;
  std::vector<Transfer> vertices_;  // of the mesh: irradiance with all bounces but the last
};

}  // namespace vitrine
