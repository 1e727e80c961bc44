// Depth and normal of single pixels from the photos around: a plane sweep. A small patch of the reference photo is carried
// onto neighbouring photos by planes at many depths and a few orientations; the plane whose patches correlate best (NCC, mean
// of the better half of the neighbours, so that one hidden view does not decide) is the answer, where it is convincing.
// Collins, "A space-sweep approach to true multi-image matching", 1996.
#pragma once

#include <optional>
#include <vector>

#include "core/camera/view.h"
#include "core/image/image.h"

namespace vitrine {

struct SweptPoint {
  double zdepth = 0;
  Vec3d normal_in_world{};  // unit, towards the camera
  double score = 0;         // mean NCC, at most 1
};

struct SweepPhoto {
  View view;    // intrinsics of the size of `grey`
  ImageF grey;  // display-referred luma; empty = the photo takes no part
};

class PlaneSweep {
 public:
  explicit PlaneSweep(std::vector<SweepPhoto> photos);

  // Pixel (x, y) of photo `reference`; z in [near_z, far_z]. Empty where the patch is flat or no plane
  // convinces. Thread-safe.
  std::optional<SweptPoint> at(uint32_t reference, double x, double y, double near_z, double far_z) const;

 private:
  struct Picture {
    View view;
    ImageF grey;
    std::vector<uint32_t> neighbours;  // indices of photos
  };
  double score(const Picture& reference, const std::vector<float>& patch, const Vec3d& ray, const Vec3d& normal, double z,
               double x, double y) const;
  std::vector<Picture> pictures_;  // [photo]
};

}  // namespace vitrine
