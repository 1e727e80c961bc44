// Light transport to the points: one jittered ray per point and direction cell. A ray that meets the mesh or the surroundings
// contributes the radiance in the photos (the bounced light of the capture: algorithms 7.3, L_ind), or none from a back side,
// which no photo shows. A ray that leaves contributes the unknown radiance of its cell, or the known one where the surroundings
// show sky. Irradiance is then linear in the unknown light:
//   E_s = E_known,s + sum_j A_sj L_j,     A_sj = NoL dOmega T where the ray of point s and cell j leaves the scene
// T: transmittance of the passed panes, without the reflected part (core/render/model/kernels/fresnel.h).
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "stages/decompose/light_grid.h"
#include "stages/decompose/lit_points.h"
#include "stages/decompose/surroundings.h"

namespace vitrine {

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

}  // namespace vitrine
