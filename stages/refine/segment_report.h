// Statistics of the glass segments of all photos, as JSON and as a picture.
#pragma once

#include <cmath>
#include <filesystem>

#include "core/foundation/base/json.h"
#include "stages/refine/glass_views.h"

namespace vitrine {

struct SegmentTotals {
  std::array<size_t, kSegmentKinds> count{};
  size_t views = 0, fallback_views = 0;  // views with glass; those with an untrusted mesh
  double share(SegmentKind kind) const;  // of the glass pixels
  double fallback_share() const;         // of the glass pixels that keep the single segment
  size_t glass = 0, fallback = 0;
};
inline double rounded(double value) { return std::round(value * 1e4) / 1e4; }  // precision of figures in the report

SegmentTotals segment_totals(std::span<const GlassView> views);
nlohmann::ordered_json segments_json(std::span<const GlassView> views, const Capture& capture);

// Writes up to twelve photos side by side with coloured glass: green between front and back, blue an open pane, yellow glass that
// is opaque in the mesh, red where mesh and G-buffer disagree; photos with an untrusted mesh have a red frame.
void write_segments_picture(const std::filesystem::path& path, std::span<const GlassView> views, const Capture& capture,
                            size_t level);

}  // namespace vitrine
