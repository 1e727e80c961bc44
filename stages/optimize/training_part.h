// One training of the optimize stage: its start or its checkpoint, its steps, its progress. A scene with an opaque twin has two,
// a capture in blocks one for each block.
#pragma once

#include <memory>

#include "stages/optimize/initialise.h"
#include "stages/optimize/trainer.h"

namespace vitrine {

// Throws Error{Resource} if the photos of `capture` alone exceed the memory limit. stage_main has already reduced max_gaussians
// to the limit (memory.cpp), as far as fewer surfels help.
void check_memory(const OptimizeConfig& config, const Capture& capture, const StageContext& context);

// Dense depth of the training photos, computed on first use.
class LazyDepth {
 public:
  LazyDepth(const OptimizeConfig& config, const Capture& capture, KnownDepthOf known, StageContext& context)
      : config_(config), capture_(capture), known_(std::move(known)), context_(context) {}
  const DenseDepth& get();
  void forget() { depth_.reset(); }

 private:
  const OptimizeConfig& config_;
  const Capture& capture_;
  KnownDepthOf known_;
  StageContext& context_;
  std::optional<DenseDepth> depth_;
};

struct TrainingPart {
  std::string name;    // "opaque twin, "; empty: the scene itself
  double from, share;  // of the stage's progress
  std::filesystem::path checkpoint;
  std::filesystem::path previews = {};  // empty: none
};

// Resumes from the checkpoint if it is valid.
std::unique_ptr<Trainer> started(const TrainerSetup& setup, const std::filesystem::path& checkpoint, LazyDepth& depth,
                                 StageContext& context);
// All remaining steps. Throws Error{Diverged} if nothing usable is left at the end.
void train(const OptimizeConfig& config, const Capture& capture, Trainer& trainer, const TrainingPart& part,
           StageContext& context);
size_t surfel_count(const Trainer& trainer);

}  // namespace vitrine
