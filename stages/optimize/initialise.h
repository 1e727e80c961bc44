// Initial surfels of the training: one per sparse point, facing the cameras that see it, and more along pixel rays, because
// sparse points miss textureless surfaces and the far background.
#pragma once

#include <cstdint>
#include <functional>

#include "core/foundation/math/rigid.h"
#include "core/scene/surfels/layers.h"
#include "core/learn/trainer/capture.h"
#include "stages/optimize/dense_depth.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// Returns a rotation whose third column is `normal`.
Quatf rotation_facing(const Vec3f& normal);

// `keep`: accepts the positions of surfels; empty = all.
SplatLayer initial_layer(const OptimizeConfig& config, const Capture& capture, const DenseDepth& dense, size_t max_surfels,
                         const std::function<bool(const Vec3d&)>& keep = {});

}  // namespace vitrine
