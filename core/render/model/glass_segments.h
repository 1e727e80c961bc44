// Where the rays of a view's glass pixels enter and leave the glass, from the extracted mesh (algorithms 5.2):
//   front   the mesh's first surface, where it is glass and agrees with the depth of the G-buffer within max(3 voxels, 1 %)
//   back    where the ray has left every shell of glass that it entered (nested shells are passed); none behind an open pane
// C_t is then C_in of (front, back) + T_in * C_out of what lies behind. Where the mesh and the G-buffer disagree a pixel keeps
// the single segment that begins at the G-buffer's surface, and where they agree on less than four fifths of a view's glass the
// whole view does: a bad mesh must not decide what is inside.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/render/model/glass_mesh.h"

namespace vitrine {

enum class SegmentKind : unsigned char {
  None,      // no glass
  Open,      // glass without a back: one segment from `front` on
  Closed,    // two segments
  NoMesh,    // the mesh has a hole where the G-buffer has glass: single segment
  Apart,     // the two surfaces lie apart, or the mesh shows its inside: single segment
  NotGlass,  // they agree, but the mesh is opaque there: single segment
};
inline constexpr size_t kSegmentKinds = 6;
inline constexpr bool is_split(SegmentKind k) { return k == SegmentKind::Open || k == SegmentKind::Closed; }

struct GlassSegments {
  std::vector<SegmentKind> kind;   // [h,w] as found, whether the view is trusted or not
  std::vector<float> front, back;  // [h,w] distances from the eye along the unit ray; back of Closed pixels
  std::vector<uint32_t> region;    // [h,w] of the front, where the kind is Open or Closed
  std::array<size_t, kSegmentKinds> count{};
  bool trusted = false;  // enough of the glass agrees

  size_t glass() const;
  // Share of the glass pixels whose surfaces agree, without those that only the mask takes for glass; 1 without glass.
  double agreement() const;
};

struct GlassSegmentsDesc {
  float min_agreement = 0.8f;
  float tolerance_voxels = 3, tolerance_rel = 0.01f;  // the larger one counts
  float thinnest_voxels = 2;                          // a back nearer to the front is the pane's own other side
};

// `zdepth`: [h,w] of the G-buffer, 0 = no surface; `glass`: [h,w] in [0,1], glass above 1/2.
GlassSegments glass_segments(const View& view, std::span<const float> zdepth, std::span<const float> glass, const GlassMesh& mesh,
                             const GlassSegmentsDesc& desc = {});

}  // namespace vitrine
