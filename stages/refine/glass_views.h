// Per-photo data of the refine stage: G-buffer, glass pixels, and glass segments of their rays.
#pragma once

#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"
#include "core/render/model/glass_segments.h"
#include "core/render/picture/trained_scene.h"

namespace vitrine {

struct GlassView {
  uint32_t photo = 0;                // index in the capture
  const View* view = nullptr;        // at the size of the maps
  std::vector<float> zdepth = {};    // [h,w] of the G-buffer, 0 = no surface
  std::vector<float> glass = {};     // [h,w] 1 = glass in the photo's mask, or in the surfels if there is no mask
  std::vector<uint8_t> opaque = {};  // [h,w] glass neither in the mask nor in the surfels
  GlassSegments segments = {};
  bool split(size_t pixel) const { return segments.trusted && is_split(segments.kind[pixel]); }
};

struct GlassViewsDesc {
  const Capture& capture;
  const Targets& targets;
  const TrainedScene& scene;
  const GlassMesh& mesh;
  GlassSegmentsDesc segments;
  size_t level = 1;  // of the pyramid
};
// Views of the listed photos, in the order of the list.
std::vector<GlassView> glass_views(const GlassViewsDesc& desc, std::span<const uint32_t> photos);

// Votes of the photos on the position of each transmittance surfel: empty space, and the side of closed glass. Each photo that
// sees the position votes:
//   empty   the position is in front of the visible surface: opaque, or glass where the mesh agrees
//   seen    the position is possible: at the surface, or behind glass
//   inside, beyond   counts of rays through closed glass that pass the position: between front and back, or after the back
// Positions behind opaque surfaces get no votes. A surfel on a pane represents the glass itself (an unexplained reflection or
// dust), so grazing photos do not count against it.

struct SurfelVotes {
  uint32_t empty = 0, seen = 0, inside = 0, beyond = 0;
  bool on_pane = false;
};
std::vector<SurfelVotes> surfel_votes(const SplatLayer& layer, std::span<const GlassView> views, const GlassMesh& mesh);

bool stands_in_empty_space(const SurfelVotes& v);
// True if all rays that pass it have left closed glass.
bool stands_beyond(const SurfelVotes& v);

}  // namespace vitrine
