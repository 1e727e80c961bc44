// Captures whose surroundings do not stand still with the object: a turntable, a plain backdrop. Trained along, what moves in
// each photo becomes a veil before the object as the others see it. There the object is trained against its masks, alone or with
// the part of its surroundings that stands still with it: the plate of the turntable.
#pragma once

#include <functional>
#include <string>

#include "core/scene/camera/passes.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"
#include "stages/optimize/dense_depth.h"

namespace vitrine {

// Share of the sparse points' sightings by photos with an object mask that lie outside it; 1 without masks or points.
double sightings_outside_object(const Capture& capture, const Targets& targets);

enum class Trained { Everything, StillPart, ObjectAlone };

struct Surroundings {
  Trained trained = Trained::Everything;
  std::string why;  // a sentence with figures; empty: nothing was asked
};

// `wanted`: ignore, train, or auto: what the photos show of the surroundings stands still with the object, or a part of it, or
// nothing (moving_evidence.h). Masks that are proposals decide nothing. StillPart: the masks of the object are widened by what
// stands still with it, and the rim of that is ignored. `dense` is called where it is needed.
// Between passes the object was moved: what surrounds it stands elsewhere in each, and auto trains it alone.
Surroundings surroundings_to_train(WantedSurroundings wanted, const Passes& passes, const Capture& capture,
                                   const std::function<const DenseDepth&()>& dense, Targets& targets);

// Leaves the photos of the largest pass to train on and to measure by: those in which the surroundings stand still.
void keep_largest_pass(const Passes& passes, Capture& capture);

// Whether the masks allow it: at most a tenth of the photos with an object mask that have the point in the picture see it
// outside. Pixels to be ignored do not count.
bool on_object(const Capture& capture, const Targets& targets, const Vec3d& position);

}  // namespace vitrine
