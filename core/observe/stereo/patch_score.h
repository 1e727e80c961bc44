// Photometric score of a plane for a patch of a photo: the patch is warped onto another photo by the homography that the plane
// induces, H = K' (R + t n^T / d) K^-1 for the plane n.X = d in the first camera's frame, and correlated there.
#pragma once

#include <array>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

inline constexpr int kPatchRadius = 3;
inline constexpr size_t kPatchPixels = (2 * kPatchRadius + 1) * (2 * kPatchRadius + 1);
inline constexpr size_t kPatchLanes = 56;  // kPatchPixels, padded with zero-weight pixels to whole vectors

// Bilateral weights of a patch of the reference photo: they fall with the brightness difference from the centre, so that pixels
// across an edge do not count.
struct ReferencePatch {
  alignas(32) std::array<float, kPatchLanes> weight{};          // sums to 1
  alignas(32) std::array<float, kPatchLanes> weighted_value{};  // weight * (value - mean)
  alignas(32) std::array<float, kPatchLanes> value{};
  float variance = 0;

  bool flat() const { return variance < 1.5e-4f; }
};
ReferencePatch reference_patch(const ImageF& luma, int x, int y);

// Homography terms from the reference camera to another camera: K' R K^-1 and K' t.
struct Transfer {
  Mat3d rotation_part;
  Vec3d translation_part;
  Vec3d centre;  // of the other camera, in the reference camera's frame
};
Transfer transfer_between(const View& reference, const View& other);

// NCC in [-1,1] of the patch around pixel centre (x, y) with `other`, warped through the plane {X : normal.X = offset} of the
// reference camera's frame; `plane_by_pixel` = K^-T normal / offset. -2 where the other photo does not see it.
float patch_score(const ReferencePatch& patch, const ImageF& other, const Transfer& transfer, const Vec3d& plane_by_pixel,
                  double x, double y);

// Mean absolute brightness difference of the same patch, also usable for textureless patches; -2 where not seen.
float patch_difference(const ReferencePatch& patch, const ImageF& other, const Transfer& transfer, const Vec3d& plane_by_pixel,
                       double x, double y);

}  // namespace vitrine
