// Geometry of a tomographic scan on a circle. The axis of rotation is z through the origin. At angle a the source is in the
// direction (cos a, sin a, 0); seen from it, rows of a projection go to the right, (-sin a, cos a, 0), and its columns down, -z.
// Parallel beams have the same detector, and no distances.
#pragma once

#include <string>
#include <vector>

#include "core/foundation/math/voxel_grid.h"
#include "core/render/volume/volume_ray.h"

namespace vitrine {

enum class Beam { Parallel, Cone };

struct ScanGeometry {
  Beam beam = Beam::Parallel;
  double source_distance = 0;    // source to axis; cone beams
  double detector_distance = 0;  // source to detector; cone beams
  double pixel_size = 1;         // of the detector, square
  Vec2d detector_offset{};       // of the detector's middle, along rows (right) and columns (up)
  int width = 0, height = 0;     // of a projection, pixels
  std::vector<double> angles;    // radians, one per projection
  std::string unit = "mm";       // of all lengths

  // Detector length per length at the axis.
  double magnification() const { return beam == Beam::Cone ? detector_distance / source_distance : 1; }
};

inline Vec3d towards_source(double angle) { return {std::cos(angle), std::sin(angle), 0}; }
inline Vec3d along_rows(double angle) { return {-std::sin(angle), std::cos(angle), 0}; }

// Rays of a projection, [h, w].
std::vector<VolumeRay> scan_rays(const ScanGeometry& g, double angle);

// Where a point appears, in pixels (the middle of pixel 0 is 0.5), and its distance from the source over source_distance (1 for
// parallel beams).
struct DetectorPoint {
  double x, y, depth;
};
DetectorPoint detector_point(const ScanGeometry& g, double angle, const Vec3d& point);

// The cylinder that all projections see.
struct SeenCylinder {
  double radius, half_height;
};
SeenCylinder seen_cylinder(const ScanGeometry& g);
// The box around it; cells are cubes, `voxels` along x and y.
VoxelGrid<float> seen_grid(const ScanGeometry& g, int voxels);

}  // namespace vitrine
