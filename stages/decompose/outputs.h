// What a person looks at: decompose/albedo.png (photo, albedo, light on the surface), decompose/baked.png (what the product of
// the two leaves unexplained) and decompose/report.json.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/base/json.h"
#include "core/scene/camera/view.h"
#include "core/scene/surfels/layers.h"
#include "stages/decompose/decompose.h"
#include "stages/decompose/light_solver.h"
#include "stages/decompose/wall_extension.h"

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

// decompose/report.json, but for what is said of polished things.
struct FoundLight {
  const DecomposeConfig& config;
  const std::vector<LitPoint>& points;
  const std::vector<bool>& usable;
  size_t solved_with = 0;  // of the points
  double voxel = 0;
  const LightSolution& solution;
  const Surroundings& around;
  size_t shell_faces = 0;
  float sky_distance = 0;
  const ExtendedWalls& walls;
  std::optional<float> horizon;  // sine of the elevation from which on a mirror shows sky
  bool card_beside = false;      // the scale is that of a card beside the trained scene
};

nlohmann::ordered_json report_of(const FoundLight& found);

}  // namespace vitrine
