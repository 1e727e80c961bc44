// The optimize stage: surfels of up to three layers, trained on the photos of an sfm artifact through the image model.
//   reads   sfm (linear/*.exr, sparse/0, gains), masks and normals when there are any
//   writes  gaussians/{diffuse,reflection,transmittance,opaque}.ply, optimize/{views.json,report.json,previews/*.png}
//           optimize/poses.json if the poses were corrected
//           optimize/trained/masks/object/*.png if only a part of the scene was trained
// An interrupted run continues from its last checkpoint and ends with the same bytes as an uninterrupted one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/learn/loss/loss_set.h"
#include "core/learn/optim/densify.h"
#include "core/learn/optim/rates.h"
#include "core/scene/camera/view_set.h"
#include "stages/optimize/phases.h"
#include "stages/stage.h"

namespace vitrine {

// Fractions of the run that train at a quarter and at half of the photo size, coarse to fine.
struct ResolutionPhases {
  double quarter_until = 0.12, half_until = 0.45;
};

struct InitialConfig {
  int frustum_points = 80000;
  int stereo_side = 160;
};

enum class WantedSurroundings { Auto, Train, Ignore };
enum class WantedMedium { Off, Water, Haze, Auto };
enum class WantedTransients { Auto, Off };
enum class WantedPoses { Given, Auto };

struct OptimizeConfig {
  int iterations = 3000;
  int max_gaussians = 240000;
  WantedLayers layers = WantedLayers::Auto;
  bool opaque_twin = true;
  int sh_degree = 1;
  int max_side = 1280;
  Backend backend = Backend::Cpu;
  int seed = 1;
  int holdout_every = 8;
  WantedSurroundings surroundings = WantedSurroundings::Auto;
  WantedMedium medium = WantedMedium::Off;
  WantedTransients transients = WantedTransients::Off;
  WantedPoses poses = WantedPoses::Given;
  bool fill_unseen = true;
  int blocks = 1;
  int checkpoint_every = 250;
  double sh_from = 0.15;     // fraction of the run after which colour depends on the view; not an option
  int preview_every = 1000;  // steps between preview pictures, 0 = only the last; not an option
  ResolutionPhases resolution;
  InitialConfig initial;
  PhasesConfig phases;
  ShadingConfig shading;
  RatesConfig rates;
  DensifyConfig densify;
  LossSet loss;
};
void describe(Describer& d, OptimizeConfig& c);

void run_optimize(const OptimizeConfig& config, StageContext& context);
Stage optimize_stage();
StageCost optimize_cost(const CostTerms& terms);
StageReport optimize_report();

// Memory estimate of training from cameras and file names, before any image is read. With --max-memory the number of surfels is
// therefore an option of the run and part of its cache key.

inline constexpr size_t kFewestSurfels = 2000;  // smallest usable scene

// Bytes of the photos, masks and normals of all views, and of the images of one step.
size_t bytes_before_surfels(const ViewSet& views, int max_side, const std::optional<std::filesystem::path>& masks,
                            const std::optional<std::filesystem::path>& normals);
// Largest number of surfels that fits in the remaining memory, including those for unobserved regions.
size_t affordable_surfels(const OptimizeConfig& config, size_t bytes_before, size_t max_memory_bytes);
// Reduces max_gaussians if the wanted number does not fit.
std::vector<FittedOption> fit_into_memory(const OptimizeConfig& config, size_t max_memory_bytes, const InputPaths& inputs);
StageFit optimize_fit();

}  // namespace vitrine
