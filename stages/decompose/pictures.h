// What a person looks at: decompose/albedo.png (photo, albedo, light on the surface) and decompose/baked.png (what the product of
// the two leaves unexplained).
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "core/camera/view.h"
#include "core/scene/layers.h"

namespace vitrine {

struct DecomposePicturesDesc {
  const std::filesystem::path& sfm_folder;
  const std::filesystem::path& output;  // the artifact
  const SplatLayer& layer;
  float near_z = 0.01f;
  std::span<const Vec3f> albedo, irradiance;  // per surfel
  const std::vector<View>& views;
  int rows = 4;
};

// Returns the rms of the logarithm of photo / (albedo x irradiance / pi), over the pixels shown; nothing where none is shown.
std::optional<double> write_decompose_pictures(const DecomposePicturesDesc& desc);

}  // namespace vitrine
