#include "stages/tomography/scan_geometry.h"

#include <algorithm>
#include <cmath>

namespace vitrine {

std::vector<VolumeRay> scan_rays(const ScanGeometry& g, double angle) {
  std::vector<VolumeRay> rays;
  const Vec3d to_source = towards_source(angle), right = along_rows(angle), up{0, 0, 1};
  for (int y = 0; y < g.height; ++y)
    for (int x = 0; x < g.width; ++x) {
      const double u = (x + 0.5 - 0.5 * g.width) * g.pixel_size + g.detector_offset.x;
      const double v = (0.5 * g.height - y - 0.5) * g.pixel_size + g.detector_offset.y;
      if (g.beam == Beam::Parallel) {
        rays.push_back({u * right + v * up, -to_source});
        continue;
      }
      rays.push_back({g.source_distance * to_source, normalized(u * right + v * up - g.detector_distance * to_source)});
    }
  return rays;
}

DetectorPoint detector_point(const ScanGeometry& g, double angle, const Vec3d& point) {
  const double depth = g.beam == Beam::Cone ? 1 - dot(point, towards_source(angle)) / g.source_distance : 1;
  const double scale = g.magnification() / depth;
  const double u = scale * dot(point, along_rows(angle)), v = scale * point.z;
  return {(u - g.detector_offset.x) / g.pixel_size + 0.5 * g.width, 0.5 * g.height - (v - g.detector_offset.y) / g.pixel_size,
          depth};
}

SeenCylinder seen_cylinder(const ScanGeometry& g) {
  const double across = std::max(0., 0.5 * g.width * g.pixel_size - std::abs(g.detector_offset.x));
  const double up = std::max(0., 0.5 * g.height * g.pixel_size - std::abs(g.detector_offset.y));
  if (g.beam == Beam::Parallel) return {across, up};
  const double radius = g.source_distance * std::sin(std::atan(across / g.detector_distance));
  return {radius, up / g.detector_distance * (g.source_distance - radius)};
}

VoxelGrid<float> seen_grid(const ScanGeometry& g, int voxels) {
  const SeenCylinder seen = seen_cylinder(g);
  VoxelGrid<float> grid;
  grid.cell = 2 * seen.radius / voxels;
  const int layers = std::max(1, int(std::lround(2 * seen.half_height / grid.cell)));
  grid.size = {voxels, voxels, layers};
  grid.origin = {-seen.radius, -seen.radius, -0.5 * grid.cell * layers};
  return grid;
}

}  // namespace vitrine
