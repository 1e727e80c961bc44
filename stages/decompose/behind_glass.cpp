#include "stages/decompose/transport.h"

#include <algorithm>

#include "core/foundation/math/kd_tree.h"
#include "core/render/model/opened_scene.h"

namespace vitrine {

namespace {

constexpr float kOnSurfel = 2;          // voxels: points within this distance of a surfel of the layer are used
constexpr float kContentReach = 6;      // voxels from a vertex to the point that gives its radiance
constexpr float kMostBackSides = 0.5f;  // of the rays of a point
constexpr double kPointsShare = 0.4;    // of the progress

// The scene without glass; for traced glass, the transmittance layer.
SplatLayer opened_layer(const TrainedScene& scene) {
  SplatScene parts{.diffuse = scene.surfels.diffuse, .transmittance = scene.surfels.transmittance};
  if (scene.image.transmission.glass != Glass::Thin) parts.diffuse.resize(0);
  OpenedScene opened;
  without_glass_with_materials(parts, opened_degrees(parts, scene.image), opened);
  return std::move(opened.surfels);
}

std::vector<LitPoint> points_behind_glass(const BehindGlassDesc& desc, const std::function<void(double)>& progress) {
  const SplatLayer& inside = desc.scene.surfels.transmittance;
  std::vector<Vec3f> surfels(inside.size());
  for (size_t i = 0; i < surfels.size(); ++i) {
    const float* m = inside.at(Attribute::Mean, i);
    surfels[i] = {m[0], m[1], m[2]};
  }
  const auto voxel = static_cast<float>(desc.points.voxel), outer = voxel * static_cast<float>(desc.points.outer_factor);
  const KdTreef tree(surfels);
  std::vector<LitPoint> points = lit_points(opened_layer(desc.scene), desc.views, desc.points, progress);
  std::erase_if(points, [&](const LitPoint& p) { return !tree.any(p.position, kOnSurfel * (p.inner ? voxel : outer)); });
  return points;
}

std::vector<Vec3f> positions_of(const std::vector<LitPoint>& points) {
  std::vector<Vec3f> out;
  for (const LitPoint& p : points) out.push_back(p.position);
  return out;
}

// Joins the mesh of first surfaces and the content behind glass, coloured from the nearest points.
TriMesh with_content(const BehindGlassDesc& desc, const std::vector<LitPoint>& points) {
  TriMesh mesh = desc.first.mesh;
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  const std::vector<Vec3f> positions = positions_of(points);
  const auto voxel = static_cast<float>(desc.points.voxel);
  const KdTreef tree(positions);
  std::vector<KdTreef::Near> near;
  for (const Vec3f& p : desc.content.positions) {
    tree.nearest(p, 1, kContentReach * voxel, near);
    mesh.positions.push_back(p);
    mesh.colors.push_back(near.empty() ? Vec3f{} : points[near[0].index].radiance);
  }
  for (std::array<uint32_t, 3> face : desc.content.faces) {
    for (uint32_t& v : face) v += first;
    mesh.faces.push_back(face);
  }
  return mesh;
}

}  // namespace

std::vector<Vec3f> irradiance_behind_glass(const BehindGlassDesc& desc, const std::function<void(double)>& progress) {
  const std::vector<LitPoint> points = points_behind_glass(desc, [&](double f) { progress(kPointsShare * f); });
  const TriMesh mesh = with_content(desc, points);
  std::vector<float> transmission(desc.first.transmission.begin(), desc.first.transmission.end());
  if (!transmission.empty()) transmission.resize(mesh.positions.size(), 0.f);
  const Transport found = transport({mesh, transmission, desc.first.around, desc.first.shell}, points, desc.rays,
                                    [&](double f) { progress(kPointsShare + (1 - kPointsShare) * f); });
  std::vector<Vec3f> irradiance(points.size());
  std::vector<bool> usable(points.size());
  bool any = false;
  for (size_t i = 0; i < points.size(); ++i) {
    irradiance[i] = found.irradiance(i, desc.light);
    usable[i] = found.inside[i] < kMostBackSides;
    any = any || usable[i];
  }
  if (!any) return {};
  return spread_irradiance(desc.scene.surfels.transmittance, desc.points.inner, points, irradiance, usable, desc.spread);
}

}  // namespace vitrine
