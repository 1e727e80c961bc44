// Opaque twin of a scene with glass or mirrors (core/render/model/opaque_pass.h), and the per-object share of the layers in the
// blended picture. Specular pixels of some training photos are withheld from both trainings as validation pixels.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "core/render/model/image_options.h"
#include "core/scene/surfels/splat_scene.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"

namespace vitrine {

// Share of the layers outside known shapes, where both scenes have the same kind of surfels.
inline constexpr float kLayeredElsewhere = 0.5f;

// [photo] 1: validation photo.
std::vector<uint8_t> judging_photos(const Capture& capture);

// Share of the layers in the picture, by object id: the share whose blend of both pictures, in linear light, is nearest (as
// displayed) to the withheld pixels of the validation photos; 0.5 for objects with too few pixels. `options`: of the scene's
// pictures, with all shares 1.
std::map<uint16_t, double> layered_shares(const SplatScene& scene, const ImageOptions& options, const Capture& capture,
                                          const Targets& targets, std::span<const uint8_t> judges);

}  // namespace vitrine
