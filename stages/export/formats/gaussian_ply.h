// PLY format of Gaussian splatting, shared by ply-2dgs, ply-3dgs and ply-albedo. Binary little endian, all properties float:
//   x y z  nx ny nz  f_dc_0..2  f_rest_0..(3k-1)  opacity  scale_0 scale_1 [scale_2]  rot_0..3  [more]  [object_id]
// f_rest is channel-major (all red coefficients, then green, then blue; 3k = 0, 9, 24 or 45 for degree 0 to 3), opacity is a
// logit, scales are natural logarithms, rot is a quaternion w x y z. Readers show the colour 0.5 + 0.28209479 f_dc.
// Programs that follow the reference implementation of Gaussian splatting accept degree 3 alone: 62 floats with three scales.
// object_id exists if surfels have ids; 0: none.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"
#include "stages/export/formats/source.h"

namespace vitrine {

// Additional property outside the format; other readers skip it.
struct MoreProperty {
  std::string name;
  std::vector<float> values;  // [surfels]
};

// The spherical harmonics degree that readers of the layout expect; surfels of a lower one are padded with zeros.
inline constexpr int kSplatFileDegree = 3;

struct GaussianPlyDesc {
  std::vector<std::string> comments;    // header lines, without the word "comment"
  bool disk_normals = false;            // nx ny nz = third column of the rotation; else 0
  std::span<const Vec3f> normals = {};  // [surfels] or empty: nx ny nz; overrides the disk normals
  std::span<const MoreProperty> more = {};
  float thickness = 0;   // file units, written as scale_2; 0: only two scales
  int least_degree = 0;  // of f_rest: coefficients that the surfels lack are zeros
  // Converts the colour of one surfel in place before writing; coefficient-major [k][rgb], DC first.
  std::function<void(std::span<float> sh)> convert_color = {};
};

// Thickness of a disk as an ellipsoid, in file units: visually flat, and its square is representable as a float.
inline float disk_thickness(const ExportFrame& frame) { return 1e-6f * float(frame.scale); }

// Header comment that nerfstudio's readers require.
inline std::string vertical_axis(const ExportFrame& frame) { return frame.y_up() ? "Vertical Axis: y" : "Vertical Axis: z"; }

void write_gaussian_ply(const std::filesystem::path& path, const SplatLayer& layer, const GaussianPlyDesc& desc);

// Converts spherical harmonics of linear radiance to those of the sRGB value, for viewers with display-referred colour. With L(d)
// = 0.5 + sum_k Y_k(d) h_k and e = the sRGB encoding, the DC is exact, and higher bands are scaled by the slope of e:   0.5 + Y_0
// h'_0 = e(0.5 + Y_0 h_0),   h'_k = e'(L*) h_k. L* is the DC radiance, but at least the root mean square of the higher bands over
// the sphere: near black the slope of e is 12.9, and a tangent there would exaggerate faint highlights.
// [k][rgb], DC first; in place.
void encode_sh_for_display(std::span<float> sh);

// Disk normals oriented outwards, for programs that light surfels; training does not orient them. [surfels] unit. The outer side
// is that of the nearest mesh vertex within `reach`. Without such a vertex it is the side of the camera ring of radius 1 about
// the origin: inwards outside the ring, outwards inside.
std::vector<Vec3f> outward_normals(const SplatLayer& layer, const TriMesh& mesh, float reach);

}  // namespace vitrine
