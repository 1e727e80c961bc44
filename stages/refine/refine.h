// The refine stage: correction of the content behind glass with the mesh (algorithms 5.2, 5.3).
//   reads   sfm, optimize, mesh, masks when there are any
//   writes  refine/{report.json,segments.png}; refine/gaussians/*.ply and refine/model.json if the scene improved
// Interrupted training continues from the last checkpoint and ends with the same bytes. Every change is evaluated on held-out
// photos; a scene without improvement is unchanged.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>

#include "core/foundation/base/json.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"
#include "core/render/picture/trained_scene.h"
#include "stages/refine/fine_tune.h"
#include "stages/refine/glass_views.h"
#include "stages/stage.h"

namespace vitrine {

enum class ExteriorSet { Auto, Transmittance, Diffuse };
enum class GlassKind { Auto, Thin, Thick };

struct RefineConfig {
  int max_side = 0;
  ExteriorSet exterior_set = ExteriorSet::Auto;
  GlassKind glass = GlassKind::Auto;
  double ior = 1.5;
  FineTuneConfig fine_tune;
};
void describe(Describer& d, RefineConfig& c);

void run_refine(const RefineConfig& config, StageContext& context);
Stage refine_stage();
StageCost refine_cost(const CostTerms& terms);
StageReport refine_report();

// PSNR of a scene on photos: inside the glass, outside it, and overall.

struct Quality {
  double glass = 0, rest = 0, all = 0;  // dB, mean over the photos with such pixels; 0 without any
};

// Photos at full capture size with their glass pixels: from the masks, else where the scene's surfels are transparent. The pixels
// stay fixed for all measured scenes; ignored pixels are excluded.
class QualityMeter {
 public:
  QualityMeter(const TrainedScene& scene, const Capture& capture, const Targets& targets, std::span<const uint32_t> photos);
  Quality of(const TrainedScene& scene) const;

 private:
  const Capture& capture_;
  std::vector<uint32_t> photos_;
  std::vector<std::vector<uint8_t>> glass_;    // [photo][h,w]
  std::vector<std::vector<uint8_t>> ignored_;  // [photo][h,w] or empty: values of 128 and more are ignored
};

// Statistics of the glass segments of all photos, as JSON and as a picture.

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
