// What the stage knows of every photo: its G-buffer, which pixels are glass, and the segments of their rays.
#pragma once

#include "core/render/model/glass_segments.h"
#include "core/render/picture/trained_scene.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"

namespace vitrine {

struct GlassView {
  uint32_t photo = 0;                // of the capture
  const View* view = nullptr;        // at the size of the maps
  std::vector<float> zdepth = {};    // [h,w] of the G-buffer, 0 = no surface
  std::vector<float> glass = {};     // [h,w] 1 = glass by the photo's mask, or by the surfels where it has none
  std::vector<uint8_t> opaque = {};  // [h,w] neither mask nor surfels say glass
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
// Of the photos of the list. The first-named photo first.
std::vector<GlassView> glass_views(const GlassViewsDesc& desc, std::span<const uint32_t> photos);

}  // namespace vitrine
