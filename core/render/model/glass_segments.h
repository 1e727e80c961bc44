// Entry and exit points of camera rays through glass, from the extracted mesh (algorithms 5.2):
//   front   first surface of the mesh, if it is glass and its depth agrees with the G-buffer within max(3 voxels, 1 %)
//   back    point where the ray has left every glass surface that it entered (nested surfaces are skipped); none behind an
//           open pane
// C_t is then C_in of (front, back) + T_in * C_out of the scene behind. Where the mesh and the G-buffer disagree, a pixel keeps
// the single segment that starts at the G-buffer's surface. If they agree on less than four fifths of a view's glass, the whole
// view does so: a bad mesh must not define the inside.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/mesh/mesh_hits.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Glass part of an extracted mesh: the faces whose nearby diffuse surfels transmit light. Opaque objects behind or inside glass
// are closed surfaces as well; only glass faces define where a transmitted ray enters and leaves.
struct GlassMesh {
  TriMesh glass;                 // the faces of glass
  std::vector<uint32_t> region;  // [faces of glass] connected pieces, numbered by size, the largest first
  size_t regions = 0;
  float voxel = 0;  // edge of the voxels used for extraction, scene units
  MeshHits all;     // of the whole mesh
  MeshHits panes;   // of the glass

  // `voxel` > 0. The mesh may be empty.
  GlassMesh(const TriMesh& mesh, const SplatLayer& diffuse, float voxel);

 private:
  GlassMesh(const TriMesh& mesh, TriMesh glass_part, float voxel);
};

// Per face: 1 if the mean tau of nearby surfels, weighted by opacity and distance, exceeds 1/2. 0 without nearby surfels.
std::vector<uint8_t> glass_faces(const TriMesh& mesh, const SplatLayer& diffuse, float voxel);

enum class SegmentKind : unsigned char {
  None,      // no glass
  Open,      // glass without a back: one segment from `front`
  Closed,    // two segments
  NoMesh,    // the mesh has a hole where the G-buffer has glass: single segment
  Apart,     // the two surfaces are too far apart, or the mesh shows its back side: single segment
  NotGlass,  // depths agree, but the mesh is opaque there: single segment
};
inline constexpr size_t kSegmentKinds = 6;
inline constexpr bool is_split(SegmentKind k) { return k == SegmentKind::Open || k == SegmentKind::Closed; }

struct GlassSegments {
  std::vector<SegmentKind> kind;   // [h,w] as computed, independent of `trusted`
  std::vector<float> front, back;  // [h,w] distances from the eye along the unit ray; back of Closed pixels
  std::vector<uint32_t> region;    // [h,w] of the front, if the kind is Open or Closed
  std::array<size_t, kSegmentKinds> count{};
  bool trusted = false;  // enough of the glass is consistent

  size_t glass() const;
  // Share of the glass pixels whose surfaces are consistent, without NotGlass pixels; 1 without glass.
  double agreement() const;
};

struct GlassSegmentsDesc {
  float min_agreement = 0.8f;
  float tolerance_voxels = 3, tolerance_rel = 0.01f;  // the maximum counts
  float thinnest_voxels = 2;                          // a back closer to the front is the other side of the same pane
};

// `zdepth`: [h,w] of the G-buffer, 0 = no surface; `glass`: [h,w] in [0,1], glass above 1/2.
GlassSegments glass_segments(const View& view, std::span<const float> zdepth, std::span<const float> glass, const GlassMesh& mesh,
                             const GlassSegmentsDesc& desc = {});

}  // namespace vitrine
