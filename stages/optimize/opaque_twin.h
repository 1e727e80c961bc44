// The opaque twin of a scene with glass or gloss (core/render/model/opaque_pass.h), and how much of each object's pictures is the
// layers'. Glass and gloss of some training photos are withheld from both trainings, so that they can judge.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "core/render/model/image_options.h"
#include "core/scene/surfels/splat_scene.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"

namespace vitrine {

// Where no known shape is shown, both are surfels of the same kind.
inline constexpr float kLayeredElsewhere = 0.5f;

// [photo] 1: judges.
std::vector<uint8_t> judging_photos(const Capture& capture);

// Share of the layers in the picture, by id of the object: that whose mean of both, in linear light, comes nearest to what
// judging photos show of it, as displayed, in pixels that were withheld from training; a half where too few were. `options`: of
// the scene's pictures, with all shares 1.
std::map<uint16_t, double> layered_shares(const SplatScene& scene, const ImageOptions& options, const Capture& capture,
                                          const Targets& targets, std::span<const uint8_t> judges);

}  // namespace vitrine
