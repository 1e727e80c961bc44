// Per-photo data of the refine stage: G-buffer, glass pixels, and glass segments of their rays.
#pragma once

#include "core/render/model/glass_segments.h"
#include "core/render/picture/trained_scene.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"

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

}  // namespace vitrine
