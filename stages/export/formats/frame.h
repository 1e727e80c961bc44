// Coordinate frame of the output files: the scene frame (right-handed, +z up), rotated or mirrored to the axes of another program
// and scaled to a unit of length.
//   rhzu  right-handed, z up: the scene's own     rhyu  right-handed, y up (x, z, -y): glTF, three.js
//   lhzu  left-handed, z up (x, -y, z): Unreal    lhyu  left-handed, y up (x, z, y): Unity
#pragma once

#include <array>
#include <string_view>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

enum class ExportAxes { Rhzu, Rhyu, Lhzu, Lhyu };
inline constexpr std::array<std::string_view, 4> kExportAxesWords{"rhzu", "rhyu", "lhzu", "lhyu"};

struct ExportFrame {
  Mat3d axes = Mat3d::identity();  // orthogonal; determinant -1 if the handedness changes
  double scale = 1;                // file units per scene unit

  static ExportFrame of(ExportAxes axes, double scale);

  bool identity() const { return axes == Mat3d::identity() && scale == 1; }
  bool mirrored() const { return determinant(axes) < 0; }
  bool y_up() const { return axes(1, 2) != 0; }
  Vec3f point(const Vec3f& p) const { return float(scale) * direction(p); }
  Vec3f direction(const Vec3f& d) const { return cast<float>(axes) * d; }
};

// The same surface in the frame: points, normals, and corner order if the frame is mirrored.
TriMesh in_frame(const TriMesh& mesh, const ExportFrame& frame);
// Means, disks, sizes and spherical harmonics (bands do not mix: the matrix of each band is computed by projection).
SplatLayer in_frame(const SplatLayer& layer, const ExportFrame& frame);

}  // namespace vitrine
