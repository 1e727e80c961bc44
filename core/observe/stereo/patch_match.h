// PatchMatch stereo: dense depth and normal of every photo. Each pixel holds a plane (depth, normal); good planes propagate to
// their neighbours along the scan and are refined by ever smaller random changes. The score of a plane warps a small patch onto
// the neighbouring photos (the homography that the plane induces) and correlates it (NCC, bilateral weights, mean of the two best
// neighbours, so that an occluded view does not count). count_agreement() keeps the surfaces that two photos find at the same
// position. Bleyer, Rhemann, Rother, "PatchMatch Stereo", 2011; Schoenberger et al., "Pixelwise View Selection", 2016 (the
// consistency test).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/camera/view_set.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct StereoPhoto {
  View view;                         // intrinsics at the size of `luma`
  ImageF luma;                       // [h,w,1] display-referred, [0,1]
  std::vector<uint32_t> neighbours;  // indices into the list of photos
  double near_z = 0, far_z = 0;      // depth range of the surfaces
  double background_z = 0;           // depth of the background (sky) with almost no parallax between photos; 0: as far_z
  std::vector<Vec3d> hints;          // sparse points: (x, y) in pixels, z-depth
};

// Plane per pixel of one photo; [h*w] each.
struct DepthMap {
  int width = 0, height = 0;
  std::vector<float> zdepth;
  std::vector<Vec3f> normal;      // camera frame, unit, towards the camera
  std::vector<float> score;       // NCC in [-1, 1]; -1 where the photo is textureless or no neighbour sees the plane
  std::vector<uint8_t> agreeing;  // number of neighbours whose own map has the same surface there
  std::vector<uint8_t> trusted;   // 1 = reliable
  bool reliable(size_t pixel) const { return trusted[pixel] != 0; }
  size_t index(int x, int y) const { return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x); }
};

struct PatchMatchDesc {
  int iterations = 4;
  uint64_t seed = 0;
};

// Neighbours of each photo that share most of its points at a useful angle: [photo][at most `count`]. Photos without shared
// points get their nearest ones. `use`: the photos that may be neighbours and that get neighbours.
std::vector<std::vector<uint32_t>> stereo_neighbours(const ViewSet& set, std::span<const uint32_t> use, size_t count);

// The result is the same for any number of threads. Photos without neighbours get an empty map.
std::vector<DepthMap> patch_match(std::span<const StereoPhoto> photos, const PatchMatchDesc& desc);

// Fills `agreeing` and `trusted`: a pixel's point, projected to a neighbour, must lie on the neighbour's surface (2 % of the
// depth, and within 1.5 pixels when projected back). One consistent neighbour and a good score make a pixel reliable.
void count_agreement(std::span<const StereoPhoto> photos, std::span<DepthMap> maps);

// Input of PatchMatch stereo for each photo, from the poses and sparse points of a capture.

// Depth of the far background, in radii of the camera ring: cameras of a ring see it at most 1.1 degrees apart.
inline constexpr double kWithoutParallax = 100;

// Luma of Rec. 709 on encoded values. [h,w,3] -> [h,w,1].
ImageF luma_of_srgb(const ImageF& srgb);

// Fills `hints`, `near_z` and `far_z` of the photos that have a picture, from the sparse points that they see: [view of `set`].
// `far_factor`: factor on the depth of the farthest points.
void find_depth_ranges(const ViewSet& set, double far_factor, std::span<StereoPhoto> photos);

}  // namespace vitrine
