// Light transport to the points: one jittered ray per point and direction cell. A ray that meets the mesh or the surroundings
// contributes the radiance in the photos (the bounced light of the capture: algorithms 7.3, L_ind), or none from a back side,
// which no photo shows. A ray that leaves contributes the unknown radiance of its cell, or the known one where the surroundings
// show sky. Irradiance is then linear in the unknown light:
//   E_s = E_known,s + sum_j A_sj L_j,     A_sj = NoL dOmega T where the ray of point s and cell j leaves the scene
// T: transmittance of the passed panes, without the reflected part (core/render/model/kernels/fresnel.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <numbers>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/mesh/tri_mesh.h"
#include "stages/decompose/lit_points.h"
#include "stages/decompose/surroundings.h"

namespace vitrine {

// Grid of directions with equal solid angle: bands of equal height in z (Archimedes), divided into azimuths. The unknown light is
// constant per cell.

struct LightGrid {
  size_t bands = 16;  // from +z to -z
  size_t azimuths() const { return 2 * bands; }
  size_t cells() const { return bands * azimuths(); }
  float solid_angle() const { return 4 * std::numbers::pi_v<float> / static_cast<float>(cells()); }

  // u, v in [0, 1): position in the cell.
  Vec3f direction(size_t cell, float u, float v) const {
    const float z = 1 - 2 * (static_cast<float>(cell / azimuths()) + v) / static_cast<float>(bands);
    const float a = 2 * std::numbers::pi_v<float> * (static_cast<float>(cell % azimuths()) + u) / static_cast<float>(azimuths());
    const float r = std::sqrt(std::max(0.f, 1 - z * z));
    return {r * std::cos(a), r * std::sin(a), z};
  }
  size_t cell_of(const Vec3f& d) const {
    const float turn = std::atan2(d.y, d.x) / (2 * std::numbers::pi_v<float>);
    const auto index = [](float x, size_t n) {
      return static_cast<size_t>(std::clamp(x * static_cast<float>(n), 0.f, static_cast<float>(n) - 0.5f));
    };
    return index((1 - d.z) / 2, bands) * azimuths() + index(turn < 0 ? turn + 1 : turn, azimuths());
  }
  // Neighbour to the east, and to the south (cells() in the last band).
  size_t east(size_t cell) const { return cell - cell % azimuths() + (cell + 1) % azimuths(); }
  size_t south(size_t cell) const { return cell + azimuths() < cells() ? cell + azimuths() : cells(); }
};

struct TransportDesc {
  LightGrid grid;
  float reach = 0.02f;         // tolerance between surfels and mesh: rays start on a mesh face within this distance
  float offset = 0.001f;       // ray start above the mesh
  float outer_offset = 0.05f;  // the same for points outside the mesh, whose shell is coarse
  uint64_t seed = 1;
};

struct Transport {
  LightGrid grid;
  std::vector<float> open;    // [points * cells] A
  std::vector<Vec3f> known;   // [points] irradiance of rays that met something
  std::vector<float> inside;  // [points] share of the rays that met a back side: high for points below the surface
  std::span<const float> row(size_t point) const { return {open.data() + point * grid.cells(), grid.cells()}; }
  Vec3f irradiance(size_t point, std::span<const Vec3f> light) const;
};

struct TransportScene {
  const TriMesh& mesh;                  // colours: radiance
  std::span<const float> transmission;  // [vertices of mesh]: rays pass where it is high; empty: none
  const Surroundings& around;
  const TriMesh& shell;  // of `around`
};

Transport transport(const TransportScene& scene, std::span<const LitPoint> points, const TransportDesc& desc,
                    const std::function<void(double)>& progress);

// The mesh for light transport.

// Reads mesh/mesh.ply of a mesh artifact. Throws Error{Input} without area or colours.
TriMesh read_shadow_mesh(const std::filesystem::path& folder);
double area_of(const TriMesh& mesh);
// Per vertex, from the nearest surface point; `voxel`: of the points.
std::vector<float> transmission_of(const TriMesh& mesh, const std::vector<LitPoint>& points, double voxel);

// Irradiance of the transmittance-layer surfels, which are seen only through glass. Points near these surfels are sampled from
// the pictures of the scene without glass (core/render/model/opened_scene.h). They receive light like other surfaces, through the
// panes of the mesh; the content behind glass (mesh/behind_glass.ply) casts the shadows.

struct BehindGlassDesc {
  const TrainedScene& scene;
  const std::vector<View>& views;
  const TransportScene& first;      // surfaces and surrounding shell, without the content behind glass
  const TriMesh& content;           // content behind glass; may be empty; its colours are assigned here
  const std::vector<Vec3f>& light;  // [cells] the solved light
  LitPointsDesc points;
  TransportDesc rays;
  SpreadDesc spread;
};

// [surfels of the transmittance layer]; empty if no photo shows any of them.
std::vector<Vec3f> irradiance_behind_glass(const BehindGlassDesc& desc, const std::function<void(double)>& progress);

}  // namespace vitrine
