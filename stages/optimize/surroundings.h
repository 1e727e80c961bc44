// Handling of surroundings that move relative to the object (turntable, plain backdrop). Surfels trained on them would become a
// veil in front of the object in other photos. In that case only the object inside its masks is trained, or the object with the
// static part of its surroundings, such as the plate of a turntable.
#pragma once

#include <functional>
#include <string>

#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"
#include "core/scene/camera/scene_info.h"
#include "stages/optimize/initialise.h"

namespace vitrine {

// Fraction of the sparse points' observations, in photos with an object mask, outside the mask; 1 without masks or points.
double sightings_outside_object(const Capture& capture, const Targets& targets);

enum class Trained { Everything, StillPart, ObjectAlone };

struct Surroundings {
  Trained trained = Trained::Everything;
  std::string why;  // a sentence with figures; empty: no decision was made
};

// `wanted`: ignore, train or auto. Auto trains everything, the static part or the object alone, depending on what the photos show
// as static (moving_evidence.h). Proposed masks have no effect. StillPart: the object masks are widened by the static surface,
// and its boundary is ignored. `dense` is called only if needed. If the object was moved between passes, the surroundings differ
// between them, and auto trains the object alone.
Surroundings surroundings_to_train(WantedSurroundings wanted, const Passes& passes, const Capture& capture,
                                   const std::function<const DenseDepth&()>& dense, Targets& targets);

// Keeps only the photos of the largest pass for training and evaluation: the surroundings are static within a pass.
void keep_largest_pass(const Passes& passes, Capture& capture);

// True if at most a tenth of the photos with an object mask that contain the point see it outside the mask. Ignored pixels do not
// count.
bool on_object(const Capture& capture, const Targets& targets, const Vec3d& position);

}  // namespace vitrine
