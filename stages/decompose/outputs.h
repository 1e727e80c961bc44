// Pictures and report of the stage: decompose/albedo.png (photo, albedo, light on the surface), decompose/baked.png (residual of
// their product) and decompose/report.json.
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

// Returns the rms of the logarithm of photo / (albedo x irradiance / pi) over the rendered pixels; empty if there are none.
std::optional<double> write_decompose_pictures(const DecomposePicturesDesc& desc);

// decompose/report.json, except the part on mirrors and coats.
struct FoundLight {
  const DecomposeConfig& config;
  const std::vector<LitPoint>& points;
  const std::vector<bool>& usable;
  size_t solved_with = 0;  // number of points
  double voxel = 0;
  const LightSolution& solution;
  const Surroundings& around;
  size_t shell_faces = 0;
  float sky_distance = 0;
  const ExtendedWalls& walls;
  std::optional<float> horizon;     // sine of the elevation above which a mirror shows sky
  bool card_outside_scene = false;  // the scale is from a card outside the trained scene
};

nlohmann::ordered_json report_of(const FoundLight& found);

}  // namespace vitrine
