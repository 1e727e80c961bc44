// Initial surfels of the training: one per sparse point, facing the cameras that see it, and more along pixel rays, because
// sparse points miss textureless surfaces and the far background.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/foundation/math/vec.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"
#include "core/observe/stereo/known_depth.h"
#include "core/observe/stereo/scene_planes.h"
#include "core/render/model/kernels/medium.h"
#include "core/scene/shape/shape_set.h"
#include "core/scene/surfels/layers.h"
#include "stages/optimize/optimize.h"

namespace vitrine {

// Depth and normal maps of the training photos before training: PatchMatch stereo on reduced photos
// (core/observe/stereo/patch_match.h), initialised with the sparse points.

struct DenseDepth {
  std::vector<StereoPhoto> photos;  // [capture.photos]; held-out photos have no picture
  std::vector<DepthMap> maps;       // same order; empty where no other photo confirms a pixel
  std::vector<ScenePlane> planes;   // the large ones
  size_t level = 0;                 // pyramid level of the maps
  double background = 0;            // distance of content without parallax (sky), in radii of the cameras
  double reliable_share() const;    // fraction of all pixels
};

// Depth maps of the user for one photo at a level of its pyramid.
using KnownDepthOf = std::function<KnownDepth(uint32_t photo, size_t level)>;
// Those in an artifact of the normals stage, with its normals as surfaces; empty without. Pixels of glass and mirrors are
// unknown: sensors measure something else there, and surfels of their surfaces are placed by other means.
KnownDepthOf known_depth_of(const Capture& capture, const Targets& targets, const std::optional<std::filesystem::path>& normals);

// Uses the pyramid level whose longer side is nearest to `max_side`.
DenseDepth dense_depth(const Capture& capture, int max_side, double far_factor, uint64_t seed, const KnownDepthOf& known = {});

// Sample points on the shapes of glass and mirrors (core/scene/objects), for the surfels that are placed when their layer begins.
// Both are textureless; only their silhouettes determine their position.

struct SurfaceSeed {
  Vec3f position, normal;  // outwards, unit
  bool known = false;      // accurate to a fraction of a pixel (ShapeSet::Entry::exact); false on a visual hull
  float apart = 1;         // distance to its neighbours, relative to the spacing
};
struct SurfaceSeeds {
  std::vector<SurfaceSeed> points;
  float spacing = 0;  // typical distance of neighbours, scene units
};

// Samples uniformly by area, 1/128 of the longest side of all shapes apart. Appendages, which curve more than their parent, get
// six times as many; points inside the parent are dropped.
SurfaceSeeds surface_seeds(const ShapeSet& shapes);

// Nearest-neighbour distances in a point cloud.

// Root mean square distance from each point to its three nearest neighbours; 0 for a single point.
std::vector<float> neighbour_spacing(std::span<const Vec3f> points);

// Returns a rotation whose third column is `normal`.
Quatf rotation_facing(const Vec3f& normal);

// `keep`: accepts the positions of surfels; empty = all. `medium`: in front of the photos; the colours are those without it.
SplatLayer initial_layer(const OptimizeConfig& config, const Capture& capture, const DenseDepth& dense, size_t max_surfels,
                         const std::function<bool(const Vec3d&)>& keep = {}, const MediumCoefficients<double>* medium = nullptr);

}  // namespace vitrine
