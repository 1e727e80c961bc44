// Precomputed radiance transfer to diffuse positions (Sloan, Kautz and Snyder 2002; algorithms 7.7). The page of `vitrine view`
// rotates and changes distant light with it, without tracing rays.
//
//   E(x) = sum_c V_c(x) n.d_c F_c + sum_k T_k(x) L_k
//
// Direct light: the sphere is divided into 576 cells of the octahedral map. V_c: a ray into cell c leaves the scene. F_c:
// radiance times solid angle of the cell. d_c: mean direction of the light in the cell. Light from the scene: spherical harmonics
// Y_k up to degree 3 with the light's coefficients L_k = integral of L Y_k over all directions,
//   T_k = integral of (1 - V) n.l rho/pi (T_k + integral of V Y_k n.l')(x') dl
// per channel; x' is the mesh position that the ray hits. Shadow edges are blurred over one cell, about 9 degrees.
//
// Same scene and desc give the same bytes for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/scene/light/environment.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "core/render/relight/scene_surface.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

inline constexpr int kTransferDegree = 3;
inline constexpr size_t kTransferSize = sh_coefficient_count(kTransferDegree);

// Per coefficient and channel: light received, or re-emitted, for a light with coefficient 1.
using Transfer = std::array<Vec3f, kTransferSize>;
// L_k of a light, per channel; exact for the map as piecewise constant texels.
using LightHarmonics = std::array<Vec3f, kTransferSize>;

LightHarmonics light_harmonics(const Environment& environment);

inline constexpr int kCellSide = 24;
inline constexpr size_t kCells = size_t(kCellSide) * size_t(kCellSide);
struct CellLight {
  std::array<Vec3f, kCells> flux{};       // F_c
  std::array<Vec3f, kCells> direction{};  // d_c, unit
};
CellLight cell_light(const Environment& environment);

// Light received at a diffuse position.
struct ReceivedLight {
  Vec3f normal{};  // 0: no orientation; light from all directions counts with weight 1/4 (pi times the mean over the sphere)
  std::array<uint32_t, kCells / 32> open{};  // bit c: V_c
  Transfer bounced{};
};
// E, clamped to at least 0.
Vec3f irradiance(const ReceivedLight& received, const CellLight& cells, const LightHarmonics& harmonics);

struct TransferDesc {
  int rays = 64;    // per position, cosine-weighted, for light from the scene; plus one ray into each cell
  int bounces = 2;  // between surfaces of the scene; 0: direct light only
  uint64_t seed = 1;
};

class LightTransfer {
 public:
  // Computes the transfer of the mesh vertices. `surface` must outlive this object. Throws (core/foundation/base/process.h) when the program
  // must stop, like all functions below.
  explicit LightTransfer(const SceneSurface& surface, const TransferDesc& desc = {});

  // Light received by the surfels of a layer, [surfels]: at the mesh position of each surfel, or at the wall of the surroundings
  // near it. Without either, light arrives from all directions.
  std::vector<ReceivedLight> of_surfels(const SplatLayer& layer) const;

  // Light along a ray: radiance of the mesh for unit coefficients, and the share of light from outside.
  struct Arrival {
    Transfer from_scene{};
    float from_outside = 1;
    float distance = 0;  // to the surface with the largest share; 0: outside has a larger one
  };
  Arrival arriving(const Vec3f& origin, const Vec3f& direction) const;
  const SceneSurface& surface() const { return *surface_; }

 private:
  struct Place {
    Vec3f origin{}, normal{};
  };
  Transfer gathered(const Place& place, uint64_t stream, bool direct, bool bounced) const;
  ReceivedLight received(const Place& place, uint64_t stream) const;
  // Adds `share` of the radiance that leaves a mesh position.
  void add_sent(Transfer& sum, const SurfacePlace& place, float share) const;
  std::optional<Place> place_of(const Vec3f& mean, const Vec3f& normal) const;
  ReceivedLight of_surfel(const SplatLayer& layer, size_t i) const;

  const SceneSurface* surface_;
  TransferDesc desc_;
  std::vector<Transfer> vertices_;  // [v] irradiance with all bounces but the last
};

}  // namespace vitrine
