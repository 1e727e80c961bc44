// Dense depth and normal of every photo from the photos around it: PatchMatch stereo. Each pixel holds a plane (depth, normal);
// good planes spread to their neighbours as the picture is scanned, and are refined by ever smaller random changes. A plane is
// judged by carrying a small patch of the photo through it onto the neighbouring photos (the homography that the plane induces)
// and correlating there (NCC, bilateral weights, mean of the two best neighbours, so that a hidden view does not decide).
// What two photos see alike at the same place is kept: count_agreement().
// Bleyer, Rhemann, Rother, "PatchMatch Stereo", 2011; Schoenberger et al., "Pixelwise View Selection", 2016 (the consistency
// test).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct StereoPhoto {
  View view;                         // intrinsics at the size of `luma`
  ImageF luma;                       // [h,w,1] display-referred, [0,1]
  std::vector<uint32_t> neighbours;  // indices into the list of photos
  double near_z = 0, far_z = 0;      // where surfaces can be
  double background_z = 0;           // of what is so far that it hardly moves from photo to photo: the sky; 0: as far_z
  std::vector<Vec3d> hints;          // known points: (x, y) in pixels, z-depth
};

// One photo's planes; [h*w] each.
struct DepthMap {
  int width = 0, height = 0;
  std::vector<float> zdepth;
  std::vector<Vec3f> normal;      // camera frame, unit, towards the camera
  std::vector<float> score;       // NCC in [-1, 1]; -1 where the photo is flat or no neighbour sees the plane
  std::vector<uint8_t> agreeing;  // neighbours whose own map has the same surface there
  std::vector<uint8_t> trusted;   // 1 = reliable
  bool reliable(size_t pixel) const { return trusted[pixel] != 0; }
  size_t index(int x, int y) const { return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x); }
};

struct PatchMatchDesc {
  int iterations = 4;
  uint64_t seed = 0;
};

// Photos beside each photo that share most of its points under a useful angle: [photo][at most `count`]. Photos without shared
// points take their nearest ones. `use` lists the photos that may be neighbours, and those that get any.
std::vector<std::vector<uint32_t>> stereo_neighbours(const ViewSet& set, std::span<const uint32_t> use, size_t count);

// Same bytes for any number of threads. Photos without neighbours get an empty map.
std::vector<DepthMap> patch_match(std::span<const StereoPhoto> photos, const PatchMatchDesc& desc);

// Fills `agreeing` and `trusted`: a pixel's point, seen from a neighbour, must lie on the neighbour's surface (2 % of the depth,
// and within 1.5 pixels when carried back); one neighbour that agrees and a good score make a pixel reliable.
void count_agreement(std::span<const StereoPhoto> photos, std::span<DepthMap> maps);

}  // namespace vitrine
