// Depth that does not come from matching (sensors, renderers) in the maps of stereo.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "core/observe/stereo/patch_match.h"

namespace vitrine {

// Of one photo, at the size of its stereo map; empty: none.
struct KnownDepth {
  ImageF zdepth;              // [h,w,1] scene units; 0 = unknown
  std::vector<Vec3f> normal;  // [h*w] camera frame, towards the camera; 0 0 0 = unknown: the pixel is not used

  bool empty() const { return zdepth.empty(); }
};

// Puts known depths, smoothed along their surfaces, into `maps`, where the known depths of two photos agree on a surface by the rule of count_agreement(). Such
// a pixel is reliable; the others keep the result of stereo. Call count_agreement() on `maps` first. Returns the number of
// replaced pixels.
size_t join_known_depth(std::span<const StereoPhoto> photos, std::span<const KnownDepth> known, std::span<DepthMap> maps);

// Lower median of the known depths in the rectangle of width x height pixels around (x, y), in pixels of the map; at least the
// pixel there. It is a depth of the map, never a mean across an edge. 0 = unknown.
float depth_near(const ImageF& map, double x, double y, double width, double height);
ImageF resized_depth(const ImageF& map, int width, int height);

// depth/<stem>.exr of an artifact of the normals stage: channel Z, scene units.
std::filesystem::path known_depth_path(const std::filesystem::path& artifact, const View& view);

}  // namespace vitrine
