// The surfels that training starts from: one on every sparse point, facing the cameras that saw it, and more along the rays
// of pixels, because sparse points keep away from what has no texture and from the far background.
#pragma once

#include <cstdint>
#include <functional>

#include "core/foundation/math/rigid.h"
#include "core/scene/surfels/layers.h"
#include "core/learn/trainer/capture.h"
#include "stages/optimize/dense_depth.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// A rotation whose third column is `normal`.
Quatf rotation_facing(const Vec3f& normal);

// `keep`: where surfels may stand; empty = anywhere.
SplatLayer initial_layer(const OptimizeConfig& config, const Capture& capture, const DenseDepth& dense, size_t max_surfels,
                         const std::function<bool(const Vec3d&)>& keep = {});

}  // namespace vitrine
